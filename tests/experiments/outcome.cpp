#include "tests/experiments/outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "common/metrics/map_metrics.hpp"
#include "common/metrics/relations.hpp"
#include "common/metrics/trajectory_error.hpp"
#include "common/results/results.hpp"
#include "common/results/summary.hpp"
#include "common/slam.hpp"
#include "services/base/cpu_seconds.hpp"
#include "services/sources/open_laser_source.hpp"
#include "tests/experiments/setup.hpp"

namespace crsm {

namespace {

std::string LogOf(const Run& run, const std::filesystem::path& radish) {
  const std::filesystem::path plain = radish / (run.source + ".clf");
  return std::filesystem::exists(plain) ? plain.string() : plain.string() + ".gz";
}

void CompareWithRelations(const Trajectory& trajectory, const Run& run, const std::filesystem::path& radish,
                          Outcome& outcome) {
  // fr079's relations are of the robot's centre; its laser stands 4 cm behind that.
  const Pose2 T_robot_laser{run.source == "fr079" ? -0.04 : 0.0, 0.0, 0.0};
  const auto relations = ReadRelations((radish / (run.source + ".relations")).string());
  const RelationErrors errors = EvaluateRelations(relations, trajectory, T_robot_laser);
  outcome.relations_m = errors.translation_m.mean;
  outcome.relations_std_m = errors.translation_m.standard_deviation;
  outcome.relations_deg = errors.rotation_rad.mean * 180.0 / kPi;
  outcome.relations_std_deg = errors.rotation_rad.standard_deviation * 180.0 / kPi;
}

void CompareWithWorld(const Results& results, const Trajectory& trajectory, const Run& run, Outcome& outcome) {
  const World world = LoadWorld(run.source);
  const TrajectoryError error = EvaluateTrajectory(trajectory, results.truth);
  outcome.ate_mean_m = error.mean_m;
  outcome.ate_max_m = error.max_m;
  if (world.corners.empty()) return;  // environment 4: the paper measures no map there
  outcome.omse_px2 = EvaluateObstacles(results.grid, world).omse_px2;
  const CornerError corners = EvaluateCorners(results.grid, world);
  outcome.cmse_px2 = corners.cmse_px2;
  outcome.missing_corners = static_cast<double>(corners.num_missing);
}

}  // namespace

Outcome Measure(const Run& run, const std::filesystem::path& radish, const std::filesystem::path& folder) {
  if (run.measured != Measured::kRun) return MeasureMatches(run);
  const Setup setup = SetUp(run);
  const bool simulated = run.source.starts_with("env");
  const auto source =
      OpenLaserSource(simulated ? "sim:" + run.source : LogOf(run, radish), {static_cast<std::uint64_t>(run.seed)});
  Slam slam(setup.parameters, setup.parts, setup.constants);
  Results results;
  std::vector<ScanMatch> matches;
  Outcome outcome;
  double rays = 0.0;
  double evaluations = 0.0;
  double cpu_s = 0.0;
  while (auto scan = source->Next()) {
    const double start_s = CpuSeconds();
    const Slam::Step step = slam.Process(*scan);
    const ScanMatch& match = step.match;
    cpu_s += CpuSeconds() - start_s;
    if (const auto T_map_laser = source->TruePose()) results.truth.push_back({scan->utime, *T_map_laser});
    rays += match.num_critical;
    evaluations += match.evaluations;
    const int bin = (match.best_evaluation - 1) * kNumBins / run.num_evaluations;
    if (match.best_evaluation > 0) ++outcome.bins.at(static_cast<std::size_t>(std::min(bin, kNumBins - 1)));
    matches.push_back(match);
    results.last_scan = step.scan;
  }
  // With loops, what the matcher sees is the map around the robot.
  results.grid = slam.closes_loops() ? slam.Finalize(matches).map.ToDenseGrid() : slam.map().ToDenseGrid();
  Trajectory trajectory;
  for (const ScanMatch& match : matches) trajectory.push_back({match.utime, match.T_map_laser});
  results.matches = matches;
  RunStatistics statistics;
  for (const ScanMatch& match : matches) statistics.Add(match);
  Summary summary;
  summary.values = statistics.values();
  summary.explored_area_m2 = ComputeExploredArea(results.grid);
  summary.parameters["slam_offline"] = ListParameters(setup.parameters);
  results.summary = summary;

  outcome.scans = static_cast<double>(matches.size());
  outcome.mfv = summary.values.mean_fitness;
  outcome.rays = rays / outcome.scans;
  outcome.evaluations = evaluations / outcome.scans;
  outcome.cpu_ms = 1000.0 * cpu_s / outcome.scans;
  if (!folder.empty()) WriteResults(folder, results);
  if (simulated) {
    CompareWithWorld(results, trajectory, run, outcome);
  } else {
    CompareWithRelations(trajectory, run, radish, outcome);
  }
  return outcome;
}

}  // namespace crsm
