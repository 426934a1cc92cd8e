#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "tests/experiments/plan.hpp"

namespace crsm {

inline constexpr int kNumBins = 20;

/// What came of a run. Figures that a source cannot give are 0: OMSE to ATE of logs, relations of simulated worlds.
struct Outcome {
  double scans = 0.0;
  double mfv = 0.0;
  double omse_px2 = 0.0;
  double cmse_px2 = 0.0;  ///< infinite if a corner is not in the map
  double missing_corners = 0.0;
  double ate_mean_m = 0.0;
  double ate_max_m = 0.0;
  double rays = 0.0;    ///< critical ones, mean a scan
  double cpu_ms = 0.0;  ///< mean a scan, of one core, whatever else the machine does
  double relations_m = 0.0;
  double relations_std_m = 0.0;
  double relations_deg = 0.0;
  double relations_std_deg = 0.0;
  std::array<double, kNumBins> best_at{};  ///< scans by when their best pose was found: k-th twentieth of N_HC
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
  visit("cpu_ms", o.cpu_ms);
  visit("relations_m", o.relations_m);
  visit("relations_std_m", o.relations_std_m);
  visit("relations_deg", o.relations_deg);
  visit("relations_std_deg", o.relations_std_deg);
  int bin = 0;
  for (auto& scans : o.best_at) visit(("best_at_" + std::to_string(bin++)).c_str(), scans);
}

/// Runs it. Leaves its pictures, map and trajectory in `folder` if that is not empty.
/// `radish`: the folder of the logs, LOG.clf or LOG.clf.gz, and their LOG.relations.
Outcome Measure(const Run& run, const std::filesystem::path& radish, const std::filesystem::path& folder);

}  // namespace crsm
