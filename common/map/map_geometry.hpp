#pragma once

#include <algorithm>
#include <cmath>

#include "common/map/tile_grid.hpp"
#include "common/math/floor_to_int.hpp"

namespace crsm {

/// The one place where metres become cells.
class MapGeometry {
 public:
  explicit MapGeometry(double cell_size_m) : cell_size_m_(cell_size_m) {}

  double cell_size_m() const { return cell_size_m_; }

  /// A length or a coordinate in cells, whole and parts. The centre of cell (0, 0) is at (0.5, 0.5).
  double ToCells(double length_m) const { return length_m / cell_size_m_; }

  /// The cell that holds a point of the map frame; for a point beyond the limits of the map some cell beyond them.
  Cell CellAt(double x_m, double y_m) const {
    constexpr double kFar = 2.0 * kMaxCell;
    const auto Index = [&](double length_m) { return FloorToInt(std::clamp(ToCells(length_m), -kFar, kFar)); };
    return {Index(x_m), Index(y_m)};
  }

  /// Whether a point and all that lies within `reach_m` of it is within the limits of the map.
  bool InLimits(double x_m, double y_m, double reach_m) const {
    const double limit_m = kMaxCell * cell_size_m_ - reach_m;
    return std::abs(x_m) < limit_m && std::abs(y_m) < limit_m;  // false for NaN
  }

 private:
  double cell_size_m_;
};

}  // namespace crsm
