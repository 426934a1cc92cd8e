#include "common/scan/hits.hpp"

#include "common/math/trigonometry.hpp"

namespace crsm {

Eigen::Matrix2Xd ComputeHits(const ValidRays& rays) {
  Eigen::Matrix2Xd hits(2, static_cast<Eigen::Index>(rays.size()));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto [sin, cos] = ComputeSinCos(rays.angle_rad[i]);
    hits.col(static_cast<Eigen::Index>(i)) << rays.range_m[i] * cos, rays.range_m[i] * sin;
  }
  return hits;
}

}  // namespace crsm
