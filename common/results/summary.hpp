#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/diagnosis/verdict.hpp"
#include "common/map/dense_grid.hpp"
#include "common/match/wheel_model.hpp"
#include "common/parameters.hpp"
#include "common/results/match_sequence.hpp"

namespace crsm {

/// How long one stage took a scan.
struct StageTiming {
  double p50_ms = 0.0;
  double p95_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;
};

/// What a run came to, for summary.json.
struct Summary {
  std::string version;
  std::string identity;                           ///< of the map, as its journal has it; empty where nobody knows it
  bool ended = true;                              ///< false: written while the run goes on
  std::map<std::string, NamedValues> parameters;  ///< that each process used
  std::int64_t scans = 0;
  std::int64_t lost = 0;
  std::int64_t degenerate = 0;
  std::int64_t map_version = 0;
  double path_length_m = 0.0;  ///< from each scan that was not lost to the next one
  double explored_area_m2 = 0.0;
  std::optional<double> wall_s;                ///< that the run has taken by the clock
  double mean_fitness = 0.0;                   ///< of the matched scans (the paper's MFV), [0, 1]; 0 if there are none
  std::map<std::string, std::int64_t> counts;  ///< drops, resends, bad messages ..., by name
  std::map<std::string, StageTiming> timings;  ///< by stage
  std::optional<MapPieces> pieces;             ///< where loops were looked for
  std::optional<WheelModel::Values> wheels;    ///< where there was odometry to learn from
  std::optional<Verdict> verdict;              ///< whether the map is to be trusted; where somebody has judged it
};

/// Sums up a run match by match, however long it is.
class MatchSums {
 public:
  void Add(const ScanMatch& match);

  /// A summary with scans, lost, degenerate, path_length_m and mean_fitness of the matches so far.
  Summary Sum() const;

 private:
  Summary summary_;
  std::optional<Pose2> previous_;  ///< of the last scan that was not lost
  std::int64_t matched_ = 0;
  double fitness_sum_ = 0.0;
};

/// How much of a map is explored [m^2].
double ComputeExploredArea(const DenseGrid& grid);

/// A summary in which all that follows from poses and map is filled in: scans, lost, degenerate, path_length_m,
/// mean_fitness and explored_area_m2.
Summary Summarize(const MatchSequence& matches, const DenseGrid& grid);

/// As JSON text that ends in a newline. Numbers that are not finite become null.
std::string FormatSummary(const Summary& summary);

}  // namespace crsm
