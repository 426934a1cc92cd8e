#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "common/map/tile_grid.hpp"
#include "common/math/floor_to_int.hpp"

namespace crsm {

/// The cell that holds a point.
inline Cell CellOf(const Eigen::Vector2d& point_cells) {
  return {FloorToInt(point_cells.x()), FloorToInt(point_cells.y())};
}

/// Visits the columns from one point to another, each with the row in which the line comes in and the one in which it
/// leaves: they are one, or neighbours. Both points are u, v; the line is no steeper than 45 degrees.
template <class Visit>
void WalkColumns(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells, Visit&& visit) {
  constexpr int kFractionBits = 32;
  constexpr double kOne = 4294967296.0;
  int column = FloorToInt(from_cells.x());
  int row = FloorToInt(from_cells.y());
  const int last = FloorToInt(to_cells.x());
  if (column != last) {
    const int step = column < last ? 1 : -1;
    const double slope = (to_cells.y() - from_cells.y()) / (to_cells.x() - from_cells.x());
    const int side = step > 0 ? column + 1 : column;
    auto at = static_cast<std::int64_t>((from_cells.y() + (side - from_cells.x()) * slope) * kOne);
    const auto rise = static_cast<std::int64_t>(step * slope * kOne);
    for (; column != last; column += step, at += rise) {
      const int next_row = static_cast<int>(at >> kFractionBits);
      visit(column, row, next_row);
      row = next_row;
    }
  }
  if (row != FloorToInt(to_cells.y())) visit(column, row, row);
}

/// Visits the cells on the straight line from one point to another but for the last, two at a time, which may be the
/// same: without a branch that depends on where the line runs, which a processor would guess wrong every few cells.
template <class Visit>
void WalkCells(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells, Visit&& visit) {
  const Eigen::Vector2d way = to_cells - from_cells;
  if (std::abs(way.x()) >= std::abs(way.y())) {
    WalkColumns(from_cells, to_cells, [&](int x, int y, int next_y) { visit(Cell{x, y}, Cell{x, next_y}); });
  } else {
    WalkColumns(from_cells.reverse(), to_cells.reverse(), [&](int y, int x, int next_x) {
      visit(Cell{x, y}, Cell{next_x, y});
    });
  }
}

}  // namespace crsm
