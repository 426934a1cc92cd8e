#pragma once

#include <cmath>
#include <map>
#include <string>

#include "tests/experiments/plan.hpp"

namespace crsm {

/// What came of a run. A figure that it cannot give is NaN.
struct Outcome {
  double mfv = NAN;
  double omse_px2 = NAN;
  double cmse_px2 = NAN;  ///< infinite if a corner is not in the map
  double ate_mean_m = NAN;
  double rays = NAN;    ///< critical ones, mean a scan
  double cpu_ms = NAN;  ///< mean a scan, of one core, whatever else the machine does

  // Of single matches while the robot drives. The true pose is the last pose moved as the robot truly moved; a match
  // is off if it is more than a cell from there. Means and shares of the matches.
  double last_fitness = NAN;   ///< at the last pose: standing still
  double true_fitness = NAN;   ///< at the true pose
  double found_fitness = NAN;  ///< at the pose that the search found
  double missed = NAN;         ///< off, and the true pose fits better: the search missed it
  double misled = NAN;         ///< off, and fits at least as well as the true pose: the map misleads
  double way = NAN;            ///< found motion along the true one, as a share of it
  double draws = NAN;          ///< chance that a random pose of the window fits better than the last pose
};

/// By name of the run.
using Outcomes = std::map<std::string, Outcome>;

/// Runs it, or its single matches.
Outcome Measure(const Run& run);

/// Matches each scan of a simulated run by itself: Measured::kRightMap or kOwnMap.
Outcome MeasureMatches(const Run& run);

}  // namespace crsm
