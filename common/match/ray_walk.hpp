#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "common/map/byte_map.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// Whether something stands in the way of a ray: two cells of it at least, from first_m to last_m along it.
/// direction: unit vector, map frame. stands: of a cell's byte.
template <class Stands>
bool IsInTheWay(const ByteMap& map, const Pose2& laser, const Eigen::Vector2d& direction, double first_m, double last_m,
                Stands&& stands) {
  constexpr int kLeast = 2;
  constexpr double kMostSteps = 4000.0;
  const MapGeometry& geometry = map.geometry();
  const double step_m = std::max(geometry.cell_size_m(), last_m / kMostSteps);
  int num = 0;
  for (double way_m = first_m; way_m < last_m; way_m += step_m) {
    const Cell cell = geometry.CellAt(laser.x_m + way_m * direction.x(), laser.y_m + way_m * direction.y());
    if (stands(map.At(cell)) && ++num >= kLeast) return true;
  }
  return false;
}

}  // namespace crsm
