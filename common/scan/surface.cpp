#include "common/scan/surface.hpp"

#include <algorithm>
#include <cmath>

namespace crsm {
namespace {

/// Whether `c` goes on where the step from `a` to `b` points: within about 15 degrees of it and some centimetres of its
/// line, and not much further away than the hits of a plane can be from one beam to the next.
bool Continues(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
               const SurfaceConstants& constants) {
  const Eigen::Vector2d step = b - a;
  const Eigen::Vector2d next = c - b;
  const double step_length = step.norm();
  const double next_length = next.norm();
  if (next_length > constants.growth_max * step_length || step_length > constants.growth_max * next_length)
    return false;
  const double across = step.x() * next.y() - step.y() * next.x();
  return std::abs(across) <= constants.beside_max_m * step_length &&
         step.dot(next) >= constants.cosine_min * step_length * next_length;
}

}  // namespace

Gaps::Gaps(const Eigen::Matrix2Xd& hits_m, const SurfaceConstants& constants) {
  const Eigen::Index num_hits = hits_m.cols();
  for (Eigen::Index i = 0; i + 1 < num_hits; ++i) {
    const bool continued =
        (i > 0 && Continues(hits_m.col(i - 1), hits_m.col(i), hits_m.col(i + 1), constants)) ||
        (i + 2 < num_hits && Continues(hits_m.col(i + 2), hits_m.col(i + 1), hits_m.col(i), constants));
    gaps_.push_back({(hits_m.col(i + 1) - hits_m.col(i)).norm(), continued});
  }
}

std::vector<bool> Gaps::FindSurfaces(double near_m, double max_m) const {
  std::vector<bool> joined;
  for (const auto& [length_m, continued] : gaps_)
    joined.push_back(length_m <= near_m || (length_m <= max_m && continued));
  return joined;
}

bool IsAlongBeam(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, const SurfaceConstants& constants) {
  const Eigen::Vector2d way_m = to_m - from_m;
  const double across = from_m.x() * way_m.y() - from_m.y() * way_m.x();
  return std::abs(across) < constants.along_beam_sine * std::max(from_m.norm(), to_m.norm()) * way_m.norm();
}

}  // namespace crsm
