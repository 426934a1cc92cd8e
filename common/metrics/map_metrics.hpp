#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/map/dense_grid.hpp"
#include "common/metrics/distance_transform.hpp"
#include "common/worlds/world.hpp"

namespace crsm {

// How good a map of a known world is. Nothing is aligned: the map's frame is the laser's first pose, and that is known.
// A cell is an obstacle if its byte is below 127: more likely occupied than free. px2 are square cells.

/// The world as a map, in the frame of the first pose of its path: cells that a wall touches are occupied, all others
/// within its bounding box free. A wall along the border of two cells belongs to both.
DenseGrid DrawWorld(const World& world, double cell_size_m);

struct ObstacleError {
  std::int64_t num_obstacles = 0;  ///< cells of the map
  double omse_px2 = 0.0;
};

/// Mean of the squared distance from each obstacle of the map to the nearest one of the world (section 3).
/// Throws std::runtime_error if the map has no obstacle.
ObstacleError EvaluateObstacles(const DenseGrid& map, const World& world);

/// How corners are looked for.
struct CornerConstants {
  double patch_m = 0.3;    ///< to either side of the corner
  double shade_px2 = 4.5;  ///< obstacles fade with exp(-d^2 / shade_px2), d = distance to the nearest one
  std::array<double, 3> reaches_m{0.25, 0.5, 1.0};  ///< of the search, one after the other until the corner is found
  double likeness_min = 0.75;                       ///< above it a corner is in the map
};

struct CornerMatch {
  std::string name;
  double dx_px = 0.0;  ///< from where the corner is to where the map has it
  double dy_px = 0.0;
  double likeness = 0.0;  ///< [-1, 1]; as of CornerConstants::likeness_min
  bool found = false;
};

struct CornerError {
  std::vector<CornerMatch> corners;  ///< in the world's order
  std::int64_t num_missing = 0;
  double cmse_px2 = 0.0;  ///< mean over the found ones of the squared distance (section 3); infinite if one is missing
};

/// Finds the named corners of the world in the map.
///
/// Both are pictures of exp(-d^2 / 4.5 px2), d = distance to the nearest obstacle. A patch of 0.3 m around the corner,
/// made from the world's exact walls, is laid over the map at every shift of up to 0.25 m, then 0.5 and 1 m, until the
/// normalised cross-correlation of the two is above likeness_min; parabolas through the best shift and its neighbours
/// give the parts of a cell. The nearest likeness wins over a better one further away, because walls repeat. Throws
/// std::runtime_error if the world names no corner.
CornerError EvaluateCorners(const DenseGrid& map, const World& world, const CornerConstants& constants = {});

}  // namespace crsm
