#include "common/metrics/map_metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "common/map/map_geometry.hpp"
#include "common/math/pose2.hpp"

namespace crsm {
namespace {

/// A free grid over the cells from `low` to `high`, both included.
DenseGrid MakeGrid(Cell low, Cell high, double cell_size_m) {
  DenseGrid grid{high.x - low.x + 1, high.y - low.y + 1, low.x, low.y, cell_size_m, {}};
  grid.cells.assign(grid.IndexOf(0, grid.height_cells), kFreeByte);
  return grid;
}

/// The part of `grid` on the cells of `area`, free where it has none.
DenseGrid Cover(const DenseGrid& grid, const DenseGrid& area) {
  const Cell low{area.origin_x_cells, area.origin_y_cells};
  DenseGrid covered = MakeGrid(low, {low.x + area.width_cells - 1, low.y + area.height_cells - 1}, grid.cell_size_m);
  const int shift_x = grid.origin_x_cells - low.x;
  const int shift_y = grid.origin_y_cells - low.y;
  for (int row = std::max(0, -shift_y); row < grid.height_cells && row + shift_y < covered.height_cells; ++row) {
    for (int column = std::max(0, -shift_x); column < grid.width_cells && column + shift_x < covered.width_cells;
         ++column) {
      covered.cells[covered.IndexOf(column + shift_x, row + shift_y)] = grid.cells[grid.IndexOf(column, row)];
    }
  }
  return covered;
}

/// An empty grid over both.
DenseGrid Join(const DenseGrid& a, const DenseGrid& b) {
  return MakeGrid({std::min(a.origin_x_cells, b.origin_x_cells), std::min(a.origin_y_cells, b.origin_y_cells)},
                  {std::max(a.origin_x_cells + a.width_cells, b.origin_x_cells + b.width_cells) - 1,
                   std::max(a.origin_y_cells + a.height_cells, b.origin_y_cells + b.height_cells) - 1},
                  a.cell_size_m);
}

/// The world's frame to the map's: the first pose of the path.
Pose2 StartOf(const World& world) {
  const double dx_m = world.path[1].x_m - world.path[0].x_m;
  const double dy_m = world.path[1].y_m - world.path[0].y_m;
  return {world.path[0].x_m, world.path[0].y_m, std::atan2(dy_m, dx_m)};
}

std::vector<Wall> WallsInMap(const World& world) {
  const Pose2 T_map_world = Inverse(StartOf(world));
  std::vector<Wall> walls;
  for (const Wall& wall : world.walls) {
    if (wall.stay.IsEndless()) walls.push_back({Apply(T_map_world, wall.from), Apply(T_map_world, wall.to)});
  }
  return walls;
}

double SquaredDistance(const Wall& wall, const Point& point) {
  const double dx = wall.to.x_m - wall.from.x_m;
  const double dy = wall.to.y_m - wall.from.y_m;
  const double length2 = dx * dx + dy * dy;
  const double along =
      length2 == 0.0 ? 0.0 : ((point.x_m - wall.from.x_m) * dx + (point.y_m - wall.from.y_m) * dy) / length2;
  const double done = std::clamp(along, 0.0, 1.0);
  const double beside_x = wall.from.x_m + done * dx - point.x_m;
  const double beside_y = wall.from.y_m + done * dy - point.y_m;
  return beside_x * beside_x + beside_y * beside_y;
}

/// How much of a wall a cell shows whose centre is this far from it.
float Shade(double squared_distance_px2, const CornerConstants& constants) {
  return static_cast<float>(std::exp(-squared_distance_px2 / constants.shade_px2));
}

/// The patch around a corner as the world has it.
struct Patch {
  Cell centre;
  int radius = 0;
  std::vector<float> shades;  ///< (2 radius + 1)^2, less their mean, of length 1
};

void Normalise(std::vector<float>& shades) {
  double sum = 0.0;
  double squares = 0.0;
  for (const float shade : shades) sum += shade;
  const double mean = sum / static_cast<double>(shades.size());
  for (float& shade : shades) {
    shade -= static_cast<float>(mean);
    squares += shade * shade;
  }
  if (squares == 0.0) return;
  for (float& shade : shades) shade /= static_cast<float>(std::sqrt(squares));
}

Patch MakePatch(const std::vector<Wall>& walls, const Point& corner, const MapGeometry& geometry,
                const CornerConstants& constants) {
  Patch patch{
      geometry.CellAt(corner.x_m, corner.y_m), static_cast<int>(std::lround(geometry.ToCells(constants.patch_m))), {}};
  const double cell_m = geometry.cell_size_m();
  for (int y = -patch.radius; y <= patch.radius; ++y) {
    for (int x = -patch.radius; x <= patch.radius; ++x) {
      const Point centre{(patch.centre.x + x + 0.5) * cell_m, (patch.centre.y + y + 0.5) * cell_m};
      double nearest_m2 = HUGE_VAL;
      for (const Wall& wall : walls) nearest_m2 = std::min(nearest_m2, SquaredDistance(wall, centre));
      patch.shades.push_back(Shade(nearest_m2 / (cell_m * cell_m), constants));
    }
  }
  Normalise(patch.shades);
  return patch;
}

/// The map's picture, in which a patch is looked for.
class Shades {
 public:
  Shades(const DenseGrid& map, const CornerConstants& constants) : grid_(Cover(map, Widen(map))) {
    for (const float distance : ComputeSquaredDistances(grid_)) shades_.push_back(Shade(distance, constants));
  }

  /// Normalised cross-correlation with the patch when that is shifted by (dx, dy).
  double Likeness(const Patch& patch, int dx, int dy) const {
    double sum = 0.0;
    double squares = 0.0;
    double product = 0.0;
    std::size_t i = 0;
    for (int y = -patch.radius; y <= patch.radius; ++y) {
      for (int x = -patch.radius; x <= patch.radius; ++x, ++i) {
        const double shade = At({patch.centre.x + dx + x, patch.centre.y + dy + y});
        sum += shade;
        squares += shade * shade;
        product += shade * static_cast<double>(patch.shades[i]);
      }
    }
    const double variance = squares - sum * sum / static_cast<double>(patch.shades.size());
    return variance > 1e-9 ? product / std::sqrt(variance) : 0.0;
  }

 private:
  double At(Cell cell) const {
    const int column = cell.x - grid_.origin_x_cells;
    const int row = cell.y - grid_.origin_y_cells;
    if (column < 0 || row < 0 || column >= grid_.width_cells || row >= grid_.height_cells) return 0.0;
    return static_cast<double>(shades_[grid_.IndexOf(column, row)]);
  }

  /// A rim on which an obstacle at the edge of the map fades out.
  static DenseGrid Widen(const DenseGrid& map) {
    constexpr int kRim = 8;  // where nothing is left of its shade
    return MakeGrid({map.origin_x_cells - kRim, map.origin_y_cells - kRim},
                    {map.origin_x_cells + map.width_cells - 1 + kRim, map.origin_y_cells + map.height_cells - 1 + kRim},
                    map.cell_size_m);
  }

  DenseGrid grid_;
  std::vector<float> shades_;
};

/// Where the parabola through three values at -1, 0 and 1 has its optimum; the middle one is not the smallest.
double OptimumOf(double before, double at, double after) {
  const double bend = before - 2.0 * at + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

CornerMatch FindCorner(const Shades& shades, const Patch& patch, const std::string& name, const MapGeometry& geometry,
                       const CornerConstants& constants) {
  CornerMatch best{name, 0.0, 0.0, -1.0, false};
  int best_dx = 0;
  int best_dy = 0;
  int searched = -1;
  for (const double reach_m : constants.reaches_m) {
    const auto reach = static_cast<int>(std::lround(geometry.ToCells(reach_m)));
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        if (std::max(std::abs(dx), std::abs(dy)) <= searched) continue;
        const double likeness = shades.Likeness(patch, dx, dy);
        if (likeness <= best.likeness) continue;
        best.likeness = likeness;
        best_dx = dx;
        best_dy = dy;
      }
    }
    searched = reach;
    // A best one on the rim may be the slope of a better one outside.
    best.found = best.likeness > constants.likeness_min && std::max(std::abs(best_dx), std::abs(best_dy)) < reach;
    if (best.found) break;
  }
  const auto At = [&](int dx, int dy) { return shades.Likeness(patch, best_dx + dx, best_dy + dy); };
  best.dx_px = best_dx + OptimumOf(At(-1, 0), best.likeness, At(1, 0));
  best.dy_px = best_dy + OptimumOf(At(0, -1), best.likeness, At(0, 1));
  return best;
}

}  // namespace

DenseGrid DrawWorld(const World& world, double cell_size_m) {
  constexpr double kStep_cells = 0.1;
  constexpr double kHair_cells = 1e-6;
  const MapGeometry geometry(cell_size_m);
  const std::vector<Wall> walls = WallsInMap(world);
  Point low_m = walls.front().from;
  Point high_m = low_m;
  for (const Wall& wall : walls) {
    for (const Point& end : {wall.from, wall.to}) {
      low_m = {std::min(low_m.x_m, end.x_m), std::min(low_m.y_m, end.y_m)};
      high_m = {std::max(high_m.x_m, end.x_m), std::max(high_m.y_m, end.y_m)};
    }
  }
  const Cell low = geometry.CellAt(low_m.x_m, low_m.y_m);
  const Cell high = geometry.CellAt(high_m.x_m, high_m.y_m);
  DenseGrid grid = MakeGrid({low.x - 1, low.y - 1}, {high.x + 1, high.y + 1}, cell_size_m);
  const auto Whole = [](double cells) { return static_cast<int>(std::floor(cells)); };
  for (const Wall& wall : walls) {
    const double dx_cells = geometry.ToCells(wall.to.x_m - wall.from.x_m);
    const double dy_cells = geometry.ToCells(wall.to.y_m - wall.from.y_m);
    const int num_steps =
        static_cast<int>(std::ceil(std::sqrt(dx_cells * dx_cells + dy_cells * dy_cells) / kStep_cells));
    for (int step = 0; step <= num_steps; ++step) {
      const double done = num_steps == 0 ? 0.0 : static_cast<double>(step) / num_steps;
      const double x_cells = geometry.ToCells(wall.from.x_m) + done * dx_cells - grid.origin_x_cells;
      const double y_cells = geometry.ToCells(wall.from.y_m) + done * dy_cells - grid.origin_y_cells;
      for (int row = Whole(y_cells - kHair_cells); row <= Whole(y_cells + kHair_cells); ++row) {
        for (int column = Whole(x_cells - kHair_cells); column <= Whole(x_cells + kHair_cells); ++column) {
          grid.cells[grid.IndexOf(column, row)] = kOccupiedByte;
        }
      }
    }
  }
  return grid;
}

ObstacleError EvaluateObstacles(const DenseGrid& map, const World& world) {
  const DenseGrid truth = DrawWorld(world, map.cell_size_m);
  const DenseGrid area = Join(map, truth);
  const std::vector<float> distances = ComputeSquaredDistances(Cover(truth, area));
  const DenseGrid covered = Cover(map, area);
  ObstacleError error;
  double sum_px2 = 0.0;
  for (std::size_t i = 0; i < covered.cells.size(); ++i) {
    if (!IsOccupied(covered.cells[i])) continue;
    ++error.num_obstacles;
    sum_px2 += static_cast<double>(distances[i]);
  }
  if (error.num_obstacles == 0) throw std::runtime_error("the map has no obstacle, so there is no OMSE");
  error.omse_px2 = sum_px2 / static_cast<double>(error.num_obstacles);
  return error;
}

CornerError EvaluateCorners(const DenseGrid& map, const World& world, const CornerConstants& constants) {
  if (world.corners.empty()) throw std::runtime_error("the world names no corner, so there is no CMSE");
  const MapGeometry geometry(map.cell_size_m);
  const std::vector<Wall> walls = WallsInMap(world);
  const Pose2 T_map_world = Inverse(StartOf(world));
  const Shades shades(map, constants);
  CornerError error;
  for (const Corner& corner : world.corners) {
    const Patch patch = MakePatch(walls, Apply(T_map_world, corner.at), geometry, constants);
    const CornerMatch match = FindCorner(shades, patch, corner.name, geometry, constants);
    error.corners.push_back(match);
    if (match.found) {
      error.cmse_px2 += match.dx_px * match.dx_px + match.dy_px * match.dy_px;
    } else {
      ++error.num_missing;
    }
  }
  error.cmse_px2 = error.num_missing > 0 ? std::numeric_limits<double>::infinity()
                                         : error.cmse_px2 / static_cast<double>(error.corners.size());
  return error;
}

}  // namespace crsm
