#pragma once

#include <Eigen/Core>
#include <cmath>

#include "common/map/tile_grid.hpp"

namespace crsm {

/// std::floor is a function call on the x86-64 that every machine has.
inline int FloorToInt(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < truncated ? 1 : 0);
}

/// The cell that holds a point.
inline Cell CellOf(const Eigen::Vector2d& point_cells) {
  return {FloorToInt(point_cells.x()), FloorToInt(point_cells.y())};
}

/// Visits the cells on the straight line from one point to another but for the last, each step crossing one side of a
/// cell (Amanatides and Woo 1987).
template <class Visit>
void WalkCells(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells, Visit&& visit) {
  Cell cell = CellOf(from_cells);
  const Cell last = CellOf(to_cells);
  const Eigen::Vector2d way = to_cells - from_cells;
  const Cell step{way.x() < 0 ? -1 : 1, way.y() < 0 ? -1 : 1};
  // Parts of the way from one side of a cell to the next, and to the first one.
  const Eigen::Vector2d per_cell = way.cwiseAbs().cwiseInverse();  // infinite on an axis without motion
  const auto ToFirstSide = [](double from, int at, int toward) { return toward > 0 ? at + 1 - from : from - at; };
  double next_x = way.x() == 0.0 ? HUGE_VAL : ToFirstSide(from_cells.x(), cell.x, step.x) * per_cell.x();
  double next_y = way.y() == 0.0 ? HUGE_VAL : ToFirstSide(from_cells.y(), cell.y, step.y) * per_cell.y();
  while (cell.x != last.x && cell.y != last.y) {
    visit(cell);
    if (next_x < next_y) {
      cell.x += step.x;
      next_x += per_cell.x();
    } else {
      cell.y += step.y;
      next_y += per_cell.y();
    }
  }
  for (; cell.x != last.x; cell.x += cell.x < last.x ? 1 : -1) visit(cell);
  for (; cell.y != last.y; cell.y += cell.y < last.y ? 1 : -1) visit(cell);
}

}  // namespace crsm
