#include "accuracy/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "common/metrics/relations.hpp"
#include "common/metrics/trajectory_error.hpp"
#include "parameters_of.hpp"
#include "services/base/cpu_seconds.hpp"
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

Trajectory TrajectoryOf(const Outcome& outcome) {
  Trajectory trajectory;
  for (const ScanMatch& match : outcome.matches) trajectory.push_back({match.utime, match.T_map_laser});
  return trajectory;
}

/// Loops move poses; and they are right or wrong themselves.
void CloseLoops(Slam& slam, const Trajectory& truth, Outcome& outcome) {
  Slam::Outcome closed = slam.Finalize(outcome.matches);
  outcome.map = std::make_shared<ByteMap>(std::move(closed.map));
  outcome.graph = std::move(closed.graph);
  for (const Loop& loop : outcome.graph.loops()) {
    outcome.worst_loop_m = std::max(outcome.worst_loop_m, ErrorOf(loop, outcome.graph, truth).value_or(0.0));
  }
}

}  // namespace

std::optional<double> ErrorOf(const Loop& loop, const KeyframeGraph& graph, const Trajectory& truth) {
  const auto TruePose = [&](KeyframeId id) {
    const std::int64_t utime = graph.keyframe(id).utime;
    return std::find_if(truth.begin(), truth.end(), [&](const StampedPose& at) { return at.utime == utime; });
  };
  const auto older = TruePose(loop.older);
  const auto newer = TruePose(loop.newer);
  if (older == truth.end() || newer == truth.end()) return std::nullopt;
  return Length(Inverse(Inverse(older->T_map_laser) * newer->T_map_laser) * loop.T_older_newer);
}

Recording Record(LaserSource& source, int every) {
  Recording recording;
  for (int i = 0; auto scan = source.Next(); ++i) {
    if (i % every != 0) continue;
    if (const auto T_start_laser = source.TruePose()) recording.truth.push_back({scan->utime, *T_start_laser});
    recording.odometry.push_back(source.Odometry());
    recording.scans.push_back(std::move(*scan));
  }
  return recording;
}

Recording Record(const std::string& source, const Parameters& parameters, int every) {
  return Record(*OpenLaserSource(source, {parameters.match.seed}), every);
}

Parameters ShippedParameters(const std::string& preset, std::uint64_t seed, const std::vector<std::string>& flags) {
  std::vector<std::string> words{"--seed", std::to_string(seed)};
  if (!preset.empty()) words.insert(words.end(), {"--preset", preset});
  words.insert(words.end(), flags.begin(), flags.end());
  return ParametersOf(words);
}

Outcome Map(const Recording& recording, const Parameters& parameters,
            const std::function<void(const Slam::Step&)>& look) {
  const auto slam_owner = std::make_shared<Slam>(parameters);
  Slam& slam = *slam_owner;
  std::vector<ScanMatch> matches;
  std::vector<double> cpu_s;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const double start_s = CpuSeconds();
    const bool has_odometry = recording.uses_odometry && i < recording.odometry.size();
    const Slam::Step step = slam.Process(recording.scans[i], has_odometry ? recording.odometry[i] : std::nullopt);
    cpu_s.push_back(CpuSeconds() - start_s);
    matches.push_back(step.match);
    if (look) look(step);
  }
  Outcome outcome = Summarize(matches);
  outcome.slam = slam_owner;
  outcome.cpu_s = std::move(cpu_s);
  outcome.matches = std::move(matches);
  if (slam.closes_loops()) {
    CloseLoops(slam, recording.truth, outcome);
  } else {
    outcome.map = {slam_owner, &slam.map()};
  }
  if (!recording.truth.empty()) {
    const Trajectory trajectory = TrajectoryOf(outcome);
    const TrajectoryError error = EvaluateTrajectory(trajectory, recording.truth);
    outcome.worst_m = error.max_m;
    outcome.error_m = error.rmse_m;
    outcome.aligned_m = EvaluateTrajectory(Align(trajectory, recording.truth), recording.truth).rmse_m;
  }
  return outcome;
}

Outcome Map(const Drive& drive, const Recording& recording, const Parameters& parameters) {
  Outcome outcome = Map(recording, parameters);
  if (drive.relations.empty()) return outcome;
  const ErrorStatistics errors =
      EvaluateRelations(ReadRelations(drive.relations), TrajectoryOf(outcome), drive.T_robot_laser).translation_m;
  outcome.worst_m = errors.max;
  outcome.error_m = errors.mean;
  return outcome;
}

Outcome Map(const Drive& drive, const Parameters& parameters) {
  return Map(drive, Record(drive.source, parameters, drive.every), parameters);
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[values.size() / 2] + values[(values.size() - 1) / 2]);
}

}  // namespace crsm
