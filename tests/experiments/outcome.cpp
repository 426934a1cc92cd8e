#include "tests/experiments/outcome.hpp"

#include "common/diagnosis/run_statistics.hpp"
#include "common/metrics/map_metrics.hpp"
#include "common/metrics/trajectory_error.hpp"
#include "common/slam.hpp"
#include "services/base/cpu_seconds.hpp"
#include "services/sources/open_laser_source.hpp"
#include "tests/experiments/setup.hpp"

namespace crsm {

Outcome Measure(const Run& run) {
  if (run.measured != Measured::kRun) return MeasureMatches(run);
  const Setup setup = SetUp(run);
  const auto source = OpenLaserSource("sim:" + run.world, {static_cast<std::uint64_t>(run.seed)});
  Slam slam(setup.parameters, setup.parts, setup.constants);
  std::vector<ScanMatch> matches;
  Trajectory truth;
  Trajectory trajectory;
  double rays = 0.0;
  double cpu_s = 0.0;
  while (auto scan = source->Next()) {
    const double start_s = CpuSeconds();
    const ScanMatch match = slam.Process(*scan).match;
    cpu_s += CpuSeconds() - start_s;
    if (const auto T_map_laser = source->TruePose()) truth.push_back({scan->utime, *T_map_laser});
    rays += match.num_critical;
    matches.push_back(match);
    trajectory.push_back({match.utime, match.T_map_laser});
  }
  RunStatistics statistics;
  for (const ScanMatch& match : matches) statistics.Add(match);
  const auto num_scans = static_cast<double>(matches.size());
  Outcome outcome;
  outcome.mfv = statistics.values().mean_fitness;
  outcome.rays = rays / num_scans;
  outcome.cpu_ms = 1000.0 * cpu_s / num_scans;
  outcome.ate_mean_m = EvaluateTrajectory(trajectory, truth).mean_m;
  const World world = LoadWorld(run.world);
  if (world.corners.empty()) return outcome;  // environment 4: the paper measures no map there
  // With loops, what the matcher sees is the map around the robot.
  const DenseGrid grid = slam.closes_loops() ? slam.Finalize(matches).map.ToDenseGrid() : slam.map().ToDenseGrid();
  outcome.omse_px2 = EvaluateObstacles(grid, world).omse_px2;
  outcome.cmse_px2 = EvaluateCorners(grid, world).cmse_px2;
  return outcome;
}

}  // namespace crsm
