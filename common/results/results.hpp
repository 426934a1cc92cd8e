#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/graph/pieces.hpp"
#include "common/graph/placed_loop.hpp"
#include "common/logs/map_files.hpp"
#include "common/logs/replacement.hpp"
#include "common/map/dense_grid.hpp"
#include "common/marks/mark.hpp"
#include "common/metrics/trajectory.hpp"
#include "common/results/match_sequence.hpp"
#include "common/results/summary.hpp"
#include "common/scan/critical_rays.hpp"

namespace crsm {

/// What a run leaves behind, or has so far.
struct Results {
  DenseGrid grid;                       ///< may be empty
  MatchSequence matches;                ///< of every scan, lost and floating ones too
  Trajectory truth;                     ///< where the laser truly stood, from its first pose; empty if nobody knows
  CriticalRays last_scan;               ///< as it was measured; drawn if `matches` has its pose
  std::optional<Summary> summary = {};  ///< for summary.json, and for the overview's caption
  std::string graph_g2o = {};           ///< made by FormatG2o; empty where there is no pose graph
  /// Gives the text of trajectory.tum where it is made already, so that a long one is not made again for each writing;
  /// where this is empty it is made of `matches`.
  std::function<void(const Sink&)> trajectory_text = {};
  std::vector<PlacedLoop> loops = {};  ///< for the overview
  MapPieces pieces = {};               ///< likewise
  std::string name = {};               ///< of the run, likewise; empty if it has none
  std::vector<PlacedMark> marks = {};
  std::string team = {};  ///< for map.tif; empty: there is none
};

/// The name of a run whose results are in this folder: the folder's.
std::string NameOfRun(const std::filesystem::path& dir);

/// Writes into `dir`, which is made if need be:
/// - map.png: 8-bit grey, a pixel a cell, the cell's byte as it is, y up in the picture; equal grids give equal bytes
///   from one build. An empty grid gives one unexplored cell, of 1 m if the grid does not know its cell size.
/// - map.pgm: the same picture, for tools that read no PNG
/// - map.yaml: the map_server convention; origin is the lower left corner [m, m, rad]
/// - overview.png: the map with trajectory, loops, last scan and verdict, for people
/// - trajectory.tum: T_map_laser of every scan but those that float: they have a frame of their own
/// - truth.tum: the true poses, if there are any
/// - graph.g2o: the pose graph, if there is one
/// - summary.json: of the summary; {} where there is none
/// - marks.csv, marks.geojson, keepout.png, slow.png and their yaml: of the marks, where there are such
/// - map.tif: where there is a team, as of EncodeRescueMap
/// What was made of an earlier map and edits.json is removed.
///
/// Each file is replaced as a whole, so a reader never sees half of one, and none before all are written: where one
/// cannot be, the older ones stay. Who reads map.yaml and then the picture that it names gets both of one map, or finds
/// that the picture has gone (map_picture.hpp). Throws
/// std::runtime_error that names the path and the reason, std::invalid_argument if the grid's size is not that of its
/// cells or a pose is not finite.
void WriteResults(const std::filesystem::path& dir, const Results& results);

/// Writes the map of a piece that is not joined with the largest one into pieces/NUMBER below `dir`: map.png, map.pgm,
/// map.yaml, and trajectory.tum with the scans of the piece alone. Throws as WriteResults does.
void WritePiece(const std::filesystem::path& dir, int number, const DenseGrid& grid, const MatchSequence& matches);

/// Removes what WritePiece has written there, and nothing else. Throws std::runtime_error if that fails.
void RemovePieces(const std::filesystem::path& dir);

}  // namespace crsm
