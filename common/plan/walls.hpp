#pragma once

#include <vector>

#include "common/plan/seen_space.hpp"
#include "common/plan/wall_lines.hpp"

namespace crsm {

/// A part of a line on which something stands.
struct WallPiece {
  int line = 0;
  double from_m = 0.0;  ///< along the line
  double to_m = 0.0;
  double sigma_from_m = 0.0;
  double sigma_to_m = 0.0;
  bool from_corner = false;  ///< it ends at another wall
  bool to_corner = false;

  double length_m() const { return to_m - from_m; }
};

/// A free gap between two pieces of a line, which stand one behind the other in the list of them.
struct Doorway {
  int line = 0;
  double from_m = 0.0;
  double to_m = 0.0;
};

struct Walls {
  std::vector<WallPiece> pieces;  ///< by line, and along it
  std::vector<Doorway> doorways;  ///< a door in a thick wall has one on each face
};

/// What of the lines is wall, and where doors are in it.
Walls FindWalls(const std::vector<WallLine>& lines, const std::vector<WallStretch>& stretches, const SeenSpace& space,
                const PlanConstants& constants);

}  // namespace crsm
