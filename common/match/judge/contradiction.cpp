#include "common/match/judge/contradiction.hpp"

#include <cstdint>

#include "common/match/judge/ray_walk.hpp"

namespace crsm {
namespace {

/// Whether all cells within `reach_cells` of a place are free.
bool IsFreeAround(const ByteMap& map, double x_m, double y_m, int reach_cells) {
  const double cell_m = map.geometry().cell_size_m();
  for (int x = -reach_cells; x <= reach_cells; ++x) {
    for (int y = -reach_cells; y <= reach_cells; ++y) {
      if (map.At(map.geometry().CellAt(x_m + x * cell_m, y_m + y * cell_m)) <= kUnexploredByte) return false;
    }
  }
  return true;
}

/// Whether a ray passes through what surely stands, and not just before its end.
bool PassesThrough(const ByteMap& map, const Pose2& laser, const Eigen::Vector2d& direction, double range_m,
                   const MatchConstants::Contradiction& constants) {
  const double cell_m = map.geometry().cell_size_m();
  const auto SurelyStands = [least_free = constants.surely_below](std::uint8_t byte) { return byte < least_free; };
  return IsInTheWay(map, laser, direction, constants.passed_first_cells * cell_m,
                    range_m - constants.passed_before_end_cells * cell_m, SurelyStands, constants.walk);
}

}  // namespace

double ComputeContradiction(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                            const MatchConstants::Contradiction& constants) {
  if (hits_m.cols() == 0) return 0.0;
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  int num_contradicting = 0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const Eigen::Vector2d hit_m(cos * hits_m(0, i) - sin * hits_m(1, i), sin * hits_m(0, i) + cos * hits_m(1, i));
    const double range_m = hit_m.norm();
    if (IsFreeAround(map, T_map_laser.x_m + hit_m.x(), T_map_laser.y_m + hit_m.y(), constants.free_cells) ||
        PassesThrough(map, T_map_laser, hit_m / range_m, range_m, constants)) {
      ++num_contradicting;
    }
  }
  return static_cast<double>(num_contradicting) / static_cast<double>(hits_m.cols());
}

}  // namespace crsm
