#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "common/parameters.hpp"
#include "tests/experiments/plan.hpp"

namespace crsm {

inline constexpr int kNumBins = 20;

/// What came of a run. A figure that it cannot give is NaN: OMSE to ATE of logs, relations of simulated worlds.
struct Outcome {
  double scans = NAN;
  double mfv = NAN;
  double omse_px2 = NAN;
  double cmse_px2 = NAN;  ///< infinite if a corner is not in the map
  double missing_corners = NAN;
  double ate_mean_m = NAN;
  double ate_max_m = NAN;
  double rays = NAN;         ///< critical ones, mean a scan
  double evaluations = NAN;  ///< of the fitness, mean a scan
  double cpu_ms = NAN;       ///< mean a scan, of one core, whatever else the machine does
  double relations_m = NAN;
  double relations_std_m = NAN;
  double relations_deg = NAN;
  double relations_std_deg = NAN;

  // Of single matches while the robot drives. The true pose is the last pose moved as the robot truly moved; a match
  // is off if it is more than a cell from there. Means and shares of the matches.
  double last_fitness = NAN;   ///< at the last pose: standing still
  double true_fitness = NAN;   ///< at the true pose
  double found_fitness = NAN;  ///< at the pose that the search found
  double missed = NAN;         ///< off, and the true pose fits better: the search missed it
  double misled = NAN;         ///< off, and fits at least as well as the true pose: the map misleads
  double way = NAN;            ///< found motion along the true one, as a share of it
  double draws = NAN;          ///< chance that a random pose of the window fits better than the last pose

  /// Scans by when their best pose was found, the k-th twentieth of N_HC; of single matches, by how far off they are,
  /// the k-th of 20 steps of a factor 10^0.15 from 1 mm to 1 m.
  std::array<double, kNumBins> bins{};
};

/// By name of the run.
using Outcomes = std::map<std::string, Outcome>;

/// Visits name and value of each figure, in the order of the columns.
template <class AnyOutcome, class Visitor>
void VisitFigures(AnyOutcome& o, Visitor&& visit) {
  visit("scans", o.scans);
  visit("mfv", o.mfv);
  visit("omse_px2", o.omse_px2);
  visit("cmse_px2", o.cmse_px2);
  visit("missing_corners", o.missing_corners);
  visit("ate_mean_m", o.ate_mean_m);
  visit("ate_max_m", o.ate_max_m);
  visit("rays", o.rays);
  visit("evaluations", o.evaluations);
  visit("cpu_ms", o.cpu_ms);
  visit("relations_m", o.relations_m);
  visit("relations_std_m", o.relations_std_m);
  visit("relations_deg", o.relations_deg);
  visit("relations_std_deg", o.relations_std_deg);
  visit("last_fitness", o.last_fitness);
  visit("true_fitness", o.true_fitness);
  visit("found_fitness", o.found_fitness);
  visit("missed", o.missed);
  visit("misled", o.misled);
  visit("way", o.way);
  visit("draws", o.draws);
  int bin = 0;
  for (auto& scans : o.bins) visit(("bin_" + std::to_string(bin++)).c_str(), scans);
}

/// Runs it, or its single matches. Leaves its pictures, map and trajectory in `folder` if that is not empty.
/// `radish`: the folder of the logs, LOG.clf or LOG.clf.gz, and their LOG.relations.
Outcome Measure(const Run& run, const std::filesystem::path& radish, const std::filesystem::path& folder);

/// Matches each scan of a simulated run by itself: Measured::kRightMap or kOwnMap.
Outcome MeasureMatches(const Run& run);

}  // namespace crsm
