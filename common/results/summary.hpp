#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/diagnosis/changes.hpp"
#include "common/diagnosis/run_statistics.hpp"
#include "common/diagnosis/verdict.hpp"
#include "common/map/dense_grid.hpp"
#include "common/match/guess/wheel_model.hpp"
#include "common/parameters.hpp"
#include "common/results/run_origin.hpp"

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
  std::string identity;  ///< of the map, as its journal has it; empty where nobody knows it
  RunOrigin origin;
  bool ended = true;                              ///< false: written while the run goes on
  std::map<std::string, NamedValues> parameters;  ///< that each process used
  RunStatistics::Values values;                   ///< of all scans
  std::int64_t left_out = 0;                      ///< scans that were never tried: refused, dropped or repeated
  std::int64_t map_version = 0;
  double explored_area_m2 = 0.0;
  std::optional<double> wall_s;                   ///< that the run has taken by the clock
  std::map<std::string, std::int64_t> counts;     ///< drops, resends, bad messages ..., by name
  std::map<std::string, StageTiming> timings;     ///< by stage
  std::optional<MapPieces> pieces;                ///< where loops were looked for
  std::optional<WheelModel::Values> wheels;       ///< where there was odometry to learn from
  std::optional<std::vector<MapChange>> changes;  ///< since the finished map was made on which this run localises
  std::optional<Verdict> verdict;                 ///< whether the map is to be trusted; where somebody has judged it
};

/// How much of a map is explored [m^2].
double ComputeExploredArea(const DenseGrid& grid);

/// As JSON text that ends in a newline. Numbers that are not finite become null.
std::string FormatSummary(const Summary& summary);

}  // namespace crsm
