#include "common/map/walk_cells.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "catch.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

using Cells = std::set<std::pair<int, int>>;

Cells Walk(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  Cells cells;
  WalkCells(from, to, [&](Cell cell, Cell next) {
    cells.insert({cell.x, cell.y});
    cells.insert({next.x, next.y});
  });
  return cells;
}

/// How much of the line lies in a cell that is larger on each side by `margin`.
double LengthIn(Cell cell, double margin, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const Eigen::Vector2d way = to - from;
  double begin = 0.0;
  double end = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    const double low = (axis == 0 ? cell.x : cell.y) - margin;
    const double high = (axis == 0 ? cell.x : cell.y) + 1 + margin;
    if (way[axis] == 0.0) {
      if (from[axis] < low || from[axis] > high) return -1.0;
      continue;
    }
    const double a = (low - from[axis]) / way[axis];
    const double b = (high - from[axis]) / way[axis];
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return (end - begin) * way.norm();
}

}  // namespace

TEST_CASE("the cells on a line are those that it passes through, but for the last") {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    CAPTURE(i);
    // Also far from the origin, where the map ends.
    const double far = i % 4 == 0 ? 60000.0 : 0.0;
    const Eigen::Vector2d from(far + random.Uniform(-30.0, 30.0), random.Uniform(-30.0, 30.0) - far);
    const Eigen::Vector2d to = from + Eigen::Vector2d(random.Uniform(-40.0, 40.0), random.Uniform(-40.0, 40.0));
    const Cells walked = Walk(from, to);
    const Cell last = CellOf(to);
    REQUIRE(walked.count({last.x, last.y}) == 0);
    const Cell first = CellOf(from);
    REQUIRE(walked.count({first.x, first.y}) == 1);
    for (int y = std::min(first.y, last.y) - 1; y <= std::max(first.y, last.y) + 1; ++y) {
      for (int x = std::min(first.x, last.x) - 1; x <= std::max(first.x, last.x) + 1; ++x) {
        if (x == last.x && y == last.y) continue;
        constexpr double kRounding = 1e-5;
        const bool is_walked = walked.count({x, y}) == 1;
        if (is_walked) REQUIRE(LengthIn({x, y}, kRounding, from, to) >= 0.0);
        if (!is_walked) REQUIRE(LengthIn({x, y}, 0.0, from, to) < kRounding);
      }
    }
  }
}

TEST_CASE("lines along an axis, through corners and of no length have no more cells than they pass through") {
  CHECK(Walk({0.5, 0.5}, {4.5, 0.5}) == Cells{{0, 0}, {1, 0}, {2, 0}, {3, 0}});
  CHECK(Walk({0.5, 0.5}, {0.5, -2.5}) == Cells{{0, 0}, {0, -1}, {0, -2}});
  CHECK(Walk({3.0, 0.5}, {0.0, 0.5}) == Cells{{3, 0}, {2, 0}, {1, 0}});
  CHECK(Walk({0.2, 0.2}, {0.8, 0.4}).empty());
  CHECK(Walk({0.2, 0.2}, {0.2, 0.2}).empty());
  CHECK(Walk({0.9, 0.9}, {1.1, 1.05}) == Cells{{0, 0}, {1, 0}});
}

}  // namespace crsm
