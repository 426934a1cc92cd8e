#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/logs/replacement.hpp"
#include "common/map/dense_grid.hpp"
#include "common/marks/mark.hpp"
#include "common/math/point.hpp"

namespace crsm {

/// What somebody changes in a copy of a finished map. All points are in the map's frame.
struct MapEdits {
  enum class Becomes {
    kFree,       ///< occupied cells become free, as where people stood; unexplored ones stay: nobody has seen them
    kUnexplored  ///< all cells, as of rooms that a mirror or a window shows
  };
  struct Erasure {
    Becomes becomes = Becomes::kFree;
    std::vector<Point> outline;  ///< three corners and more, closed; a cell is in it if its middle is
  };

  std::vector<Point> crop;  ///< what stays: two opposite corners of a rectangle, or an outline; none: all
  std::vector<Erasure> erase;
  double turn_deg = 0.0;  ///< of the map about its origin, counter-clockwise

  static constexpr std::size_t kMostErasures = 100;
  static constexpr std::size_t kMostPoints = Mark::kMostPoints;  ///< of an outline
  static constexpr double kFarthest_m = Mark::kFarthest_m;
  static constexpr double kLargestTurn_deg = 360.0;

  bool IsEmpty() const { return crop.empty() && erase.empty() && turn_deg == 0.0; }
};

inline constexpr const char* kEditsFile = "edits.json";

/// What is made of a map and its edits.
inline constexpr std::array kEditedFiles{"map_edited.png",      "map_edited.yaml", "keepout_edited.png",
                                         "keepout_edited.yaml", "slow_edited.png", "slow_edited.yaml"};

/// Reads {"crop_m": [[x, y], ...], "erase": [{"becomes": "free", "outline_m": [[x, y], ...]}], "turn_deg": 0}. What is
/// missing changes nothing. T_edited_map may be there, and is not read. Throws std::runtime_error that names the key.
MapEdits ParseMapEdits(std::string_view json);

/// The same from a file. Throws std::runtime_error that names it, and the key.
MapEdits ReadMapEdits(const std::filesystem::path& path);

/// As ParseMapEdits reads it, with T_edited_map.
std::string FormatMapEdits(const MapEdits& edits);

/// A pose or a point of the map in the frame of the edited map: turned about the origin.
Pose2 TransformOf(const MapEdits& edits);

/// The map as it is edited: the smallest rectangle around what is left of it, with cells along the axes of its own
/// frame, which is turned by `turn_deg`. A cell of a turned map is occupied if one of four points in it is, so that
/// walls stay closed; a wall gets thicker by half a cell on average. Else it is what the map is at its middle. Without
/// a turn cells stay as they are. Throws std::runtime_error that names the key if nothing is left, or too much.
DenseGrid ApplyEdits(const DenseGrid& map, const MapEdits& edits);

/// Adds edits.json, map_edited.png and map_edited.yaml, and masks of the same cells as of AddMasks: keepout_edited and
/// slow_edited. Throws as ApplyEdits.
void AddEditedMap(const DenseGrid& map, const std::vector<PlacedMark>& marks, const MapEdits& edits,
                  Replacement& files);

}  // namespace crsm
