#include "common/metrics/map_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

constexpr double kCell_m = 0.02;

/// A room of 4 x 3 m with a box in it; the path starts at (1, 1) and faces right, so the map's frame is shifted by
/// that.
const std::string kRoom =
    "box 0 0 4 3\nbox 2.5 1.2 0.6 0.8\nlaser 180 181 8 10 0.01\nspeed 0.3 0.5\nwaypoint 1 1\nwaypoint 2 1\n"
    "corner lower_left 0 0\ncorner upper_right 4 3\ncorner box 2.5 1.2\n";

DenseGrid MakeGrid(int width, int height, std::uint8_t byte = kFreeByte) {
  DenseGrid grid{width, height, 0, 0, kCell_m, {}};
  grid.cells.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), byte);
  return grid;
}

std::uint8_t& At(DenseGrid& grid, int column, int row) {
  return grid.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width_cells) +
                    static_cast<std::size_t>(column)];
}

/// The obstacles of a grid, as cells of the map.
std::vector<std::pair<int, int>> ObstaclesOf(const DenseGrid& grid) {
  std::vector<std::pair<int, int>> obstacles;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    if (grid.cells[i] >= 127) continue;
    obstacles.emplace_back(static_cast<int>(i) % grid.width_cells + grid.origin_x_cells,
                           static_cast<int>(i) / grid.width_cells + grid.origin_y_cells);
  }
  return obstacles;
}

double SlowSquaredDistance(const std::pair<int, int>& cell, const std::vector<std::pair<int, int>>& obstacles) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [x, y] : obstacles) {
    nearest = std::min(nearest, std::pow(x - cell.first, 2) + std::pow(y - cell.second, 2));
  }
  return nearest;
}

/// What a map of the world would be that is turned about the start and shifted: each hit of 200,000 rays over its
/// walls.
DenseGrid DrawMoved(const World& world, const Pose2& T_map_true) {
  DenseGrid grid = MakeGrid(400, 400, kUnexploredByte);
  grid.origin_x_cells = -150;
  grid.origin_y_cells = -150;
  for (const Wall& wall : world.walls) {
    for (int i = 0; i <= 2000; ++i) {
      const double x_m = wall.from.x_m + (wall.to.x_m - wall.from.x_m) * i / 2000.0 - world.path[0].x_m;
      const double y_m = wall.from.y_m + (wall.to.y_m - wall.from.y_m) * i / 2000.0 - world.path[0].y_m;
      const Pose2 moved = T_map_true * Pose2{x_m, y_m, 0.0};
      At(grid, static_cast<int>(std::floor(moved.x_m / kCell_m)) + 150,
         static_cast<int>(std::floor(moved.y_m / kCell_m)) + 150) = 20;
    }
  }
  return grid;
}

}  // namespace

TEST_CASE("squared distances are those of trying every obstacle") {
  Random random(5);
  for (int trial = 0; trial < 30; ++trial) {
    CAPTURE(trial);
    DenseGrid grid = MakeGrid(1 + static_cast<int>(random.Uniform(0, 40)), 1 + static_cast<int>(random.Uniform(0, 40)));
    const int num_obstacles = static_cast<int>(random.Uniform(1, 12));
    for (int i = 0; i < num_obstacles; ++i) {
      At(grid, static_cast<int>(random.Uniform(0, grid.width_cells)),
         static_cast<int>(random.Uniform(0, grid.height_cells))) = 126;
    }
    const auto obstacles = ObstaclesOf(grid);
    const std::vector<float> distances = ComputeSquaredDistances(grid);
    REQUIRE(distances.size() == grid.cells.size());
    for (int i = 0; i < static_cast<int>(distances.size()); ++i) {
      REQUIRE(distances[static_cast<std::size_t>(i)] ==
              SlowSquaredDistance({i % grid.width_cells, i / grid.width_cells}, obstacles));
    }
  }
}

TEST_CASE("without an obstacle every distance is the largest number, and an empty grid has none") {
  for (const float distance : ComputeSquaredDistances(MakeGrid(3, 2, kUnexploredByte))) {
    CHECK(distance == std::numeric_limits<float>::max());
  }
  CHECK(ComputeSquaredDistances(MakeGrid(0, 0)).empty());
}

TEST_CASE("a world is drawn in the frame of its first pose") {
  // Facing up from (1, 1): the left wall, 1 m to the left, is at y = 1 in the map, which is the border of two cells.
  const World world =
      ParseWorld("box 0 0 4 3\nlaser 180 181 8 10 0.01\nspeed 0.3 0.5\nwaypoint 1 1\nwaypoint 1 2\n", "w");
  const auto obstacles = ObstaclesOf(DrawWorld(world, kCell_m));
  const auto Has = [&](int x, int y) {
    return std::find(obstacles.begin(), obstacles.end(), std::pair(x, y)) != obstacles.end();
  };
  CHECK(Has(0, 49));
  CHECK(Has(0, 50));
  CHECK_FALSE(Has(0, 48));
  CHECK_FALSE(Has(0, 51));
  CHECK(Has(-50, 0));   // behind
  CHECK(Has(99, 0));    // ahead
  CHECK(Has(0, -150));  // the right wall, 3 m off
  // Walls of 4 m and 3 m, two cells thick: two rings of cells, of which the inner one is 200 x 150.
  CHECK(obstacles.size() == 2 * (200 + 150) * 2);
}

TEST_CASE("OMSE is the mean over the map's obstacles of the squared distance to the nearest of the world") {
  const World world = ParseWorld(kRoom, "room");
  const auto truth = ObstaclesOf(DrawWorld(world, kCell_m));
  Random random(2);
  DenseGrid map = MakeGrid(300, 250, kUnexploredByte);  // reaches beyond the world on two sides, and not on the others
  map.origin_x_cells = -40;
  map.origin_y_cells = -60;
  for (int i = 0; i < 500; ++i) {
    At(map, static_cast<int>(random.Uniform(0, 300)), static_cast<int>(random.Uniform(0, 250))) =
        static_cast<std::uint8_t>(random.Uniform(0, 256));
  }
  double sum = 0.0;
  const auto obstacles = ObstaclesOf(map);
  for (const auto& obstacle : obstacles) sum += SlowSquaredDistance(obstacle, truth);
  const ObstacleError error = EvaluateObstacles(map, world);
  CHECK(error.num_obstacles == static_cast<std::int64_t>(obstacles.size()));
  CHECK(error.omse_px2 == Approx(sum / static_cast<double>(obstacles.size())));
}

TEST_CASE("the world's own map has no error") {
  const World world = ParseWorld(kRoom, "room");
  const DenseGrid map = DrawWorld(world, kCell_m);
  CHECK(EvaluateObstacles(map, world).omse_px2 == 0.0);
  const CornerError error = EvaluateCorners(map, world);
  CHECK(error.num_missing == 0);
  CHECK(error.cmse_px2 == Approx(0.0).margin(0.01));  // two cells thick walls are symmetric about the true line
}

TEST_CASE("corners are found where the map has them, to a part of a cell") {
  const World world = ParseWorld(kRoom, "room");
  const DenseGrid near = DrawMoved(world, {0.013, -0.027, 0.0});  // whose lines may be a cell off, and like the world's
  CHECK(EvaluateCorners(near, world).corners[0].likeness >
        EvaluateCorners(near, world, {.shade_px2 = 1.0}).corners[0].likeness);
  // Up to 0.25, 0.5 and 1 m away: one of each ring of the search. All cells are whole or parts.
  const std::vector<Pose2> shifts = {
      {0.013, -0.027, 0.0}, {0.206, 0.184, 0.0}, {-0.43, 0.33, 0.0}, {0.71, -0.83, 0.0}, {0.02, 0.01, 0.03}};
  for (const Pose2& shift : shifts) {
    CAPTURE(shift.x_m, shift.y_m, shift.yaw_rad);
    const CornerError error = EvaluateCorners(DrawMoved(world, shift), world);
    REQUIRE(error.corners.size() == 3);
    CHECK(error.num_missing == 0);
    double expected_px2 = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double x_m = world.corners[i].at.x_m - 1.0;
      const double y_m = world.corners[i].at.y_m - 1.0;
      const Pose2 moved = shift * Pose2{x_m, y_m, 0.0};
      const double dx_px = (moved.x_m - x_m) / kCell_m;
      const double dy_px = (moved.y_m - y_m) / kCell_m;
      CHECK(error.corners[i].name == world.corners[i].name);
      // Half a cell: the map's lines are cells, so they are off by up to that; and 0.1 for the parabola.
      CHECK(error.corners[i].dx_px == Approx(dx_px).margin(0.6));
      CHECK(error.corners[i].dy_px == Approx(dy_px).margin(0.6));
      expected_px2 += (dx_px * dx_px + dy_px * dy_px) / 3.0;
    }
    CHECK(std::sqrt(error.cmse_px2) == Approx(std::sqrt(expected_px2)).margin(0.85));  // that in both axes
  }
}

TEST_CASE("a corner that is not in the map is said to be missing, and there is no CMSE") {
  const World world = ParseWorld(kRoom, "room");
  DenseGrid map = DrawWorld(world, kCell_m);
  // The box at (1.5, 0.2) m in the map is wiped out; the only other corner like its lower left one is 2.5 m off.
  for (int row = 0; row < map.height_cells; ++row) {
    for (int column = 0; column < map.width_cells; ++column) {
      const int x = column + map.origin_x_cells;
      const int y = row + map.origin_y_cells;
      if (x > -45 && x < 140 && y > -45 && y < 90) At(map, column, row) = kFreeByte;
    }
  }
  const CornerError error = EvaluateCorners(map, world);
  CHECK(error.num_missing == 1);
  CHECK(error.corners[0].found);
  CHECK(error.corners[1].found);
  CHECK_FALSE(error.corners[2].found);
  CHECK(std::isinf(error.cmse_px2));
  CHECK(EvaluateCorners(MakeGrid(10, 10), world).num_missing == 3);
  CHECK(EvaluateCorners(DrawMoved(world, {-1.31, 0.02, 0.0}), world).num_missing == 3);  // further than is looked
}

TEST_CASE("metrics that have nothing to measure say so") {
  const World world = ParseWorld(kRoom, "room");
  CHECK(ErrorOf([&] { EvaluateObstacles(MakeGrid(10, 10), world); }) == "the map has no obstacle, so there is no OMSE");
  CHECK(ErrorOf([&] { EvaluateCorners(MakeGrid(10, 10), LoadWorld("demo")); }) ==
        "the world names no corner, so there is no CMSE");
}

}  // namespace crsm
