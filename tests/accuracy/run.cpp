#include "accuracy/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/metrics/relations.hpp"
#include "common/metrics/trajectory_error.hpp"
#include "common/slam.hpp"
#include "cpu_seconds.hpp"
#include "services/settings/command_line.hpp"
#include "services/sources/open_laser_source.hpp"

namespace crsm {
namespace {

/// Share lost and mean fitness.
Outcome Summarize(const std::vector<ScanMatch>& matches) {
  if (matches.empty()) throw std::runtime_error("there is no scan");
  std::size_t num_lost = 0;
  std::size_t num_matched = 0;
  double fitness = 0.0;
  for (const ScanMatch& match : matches) {
    if (match.state == MatchState::kLost) ++num_lost;
    if (match.state != MatchState::kOk && match.state != MatchState::kDegenerate) continue;
    ++num_matched;
    fitness += match.fitness;
  }
  Outcome outcome;
  outcome.lost = static_cast<double>(num_lost) / static_cast<double>(matches.size());
  outcome.mean_fitness = num_matched == 0 ? 0.0 : fitness / static_cast<double>(num_matched);
  return outcome;
}

/// Loops move poses; and they are right or wrong themselves.
void PutRight(Slam& slam, const Trajectory& truth, std::vector<ScanMatch>& matches, Outcome& outcome) {
  const Slam::Outcome put_right = slam.Finalize(matches);
  outcome.num_loops = static_cast<int>(put_right.graph.loops().size());
  std::map<std::int64_t, Pose2> true_poses;
  for (const auto& [utime, pose] : truth) true_poses[utime] = pose;
  if (true_poses.empty()) return;
  for (const Loop& loop : put_right.graph.loops()) {
    const Pose2& older = true_poses.at(put_right.graph.keyframe(loop.older).utime);
    const Pose2& newer = true_poses.at(put_right.graph.keyframe(loop.newer).utime);
    const Pose2 error = Inverse(Inverse(older) * newer) * loop.T_older_newer;
    outcome.worst_loop_m = std::max(outcome.worst_loop_m, std::hypot(error.x_m, error.y_m));
  }
}

}  // namespace

Parameters ShippedParameters(const std::string& preset, std::uint64_t seed, const std::vector<std::string>& flags) {
  using enum ParameterGroup;
  CommandLine command_line("accuracy_tests", "", {kSeed, kOdometry, kLaser, kScan, kSelection, kMatch, kUpdate, kLoops},
                           {});
  const std::string seed_text = std::to_string(seed);
  std::vector<const char*> arguments{"accuracy_tests", "--seed", seed_text.c_str()};
  if (!preset.empty()) arguments.insert(arguments.end(), {"--preset", preset.c_str()});
  for (const std::string& flag : flags) arguments.push_back(flag.c_str());
  if (command_line.Parse(static_cast<int>(arguments.size()), arguments.data())) {
    throw std::runtime_error(fmt::format("preset {} with {} is refused", preset, fmt::join(flags, " ")));
  }
  return command_line.parameters();
}

Outcome Map(const Drive& drive, const Parameters& parameters) {
  const auto source = OpenLaserSource(drive.source, {parameters.match.seed, {}, parameters.scan});
  Slam slam(parameters);
  std::vector<ScanMatch> matches;
  std::vector<double> cpu_s;
  Trajectory truth;
  for (int i = 0; const auto scan = source->Next(); ++i) {
    if (i % drive.every != 0) continue;
    const double start_s = CpuSeconds();
    matches.push_back(slam.Process(*scan).match);
    cpu_s.push_back(CpuSeconds() - start_s);
    if (const auto T_start_laser = source->TruePose()) truth.push_back({scan->utime, *T_start_laser});
  }
  Outcome outcome = Summarize(matches);
  outcome.cpu_s = std::move(cpu_s);
  if (slam.closes_loops()) PutRight(slam, truth, matches, outcome);
  Trajectory trajectory;
  for (const ScanMatch& match : matches) trajectory.push_back({match.utime, match.T_map_laser});
  if (!truth.empty()) {
    const TrajectoryError error = EvaluateTrajectory(trajectory, truth);
    outcome.worst_m = error.max_m;
    outcome.error_m = error.rmse_m;
    outcome.aligned_m = EvaluateTrajectory(Align(trajectory, truth), truth).rmse_m;
  }
  if (!drive.relations.empty()) {
    const ErrorStatistics errors =
        EvaluateRelations(ReadRelations(drive.relations), trajectory, drive.T_robot_laser).translation_m;
    outcome.worst_m = errors.max;
    outcome.error_m = errors.mean;
  }
  return outcome;
}

}  // namespace crsm
