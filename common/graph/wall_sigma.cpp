#include "common/graph/wall_sigma.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "common/math/symmetric.hpp"

namespace crsm {

WallSigma FindWallSigma(const ScanMatch& match, const MatchConstants::Uncertainty& constants, double cell_size_m) {
  const std::array<double, 6>& c = match.covariance;
  const double map_m = constants.sigma_cells * cell_size_m;
  Eigen::Matrix2d covariance;
  covariance << c[0] - map_m * map_m, c[1], c[1], c[3] - map_m * map_m;
  const auto [least, axis] = FindWeakest(-covariance);
  const double along_m2 = std::max(-least, 1e-9);
  const double across_m2 = std::max(covariance.trace() + least, 1e-9);
  WallSigma walls;
  walls.axis = TurnAxis({axis.x(), axis.y()}, -match.T_map_laser.yaw_rad);
  walls.sigma = {std::sqrt(along_m2), std::sqrt(across_m2),
                 std::sqrt(std::max(c[5] - constants.map_rad * constants.map_rad, 0.0))};
  return walls;
}

}  // namespace crsm
