#include "common/diagnosis/run_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "common/match/judge/census.hpp"
#include "common/math/random.hpp"
#include "common/scan/deskew.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

ValidRays Thin(const ValidRays& rays, std::size_t most) {
  const std::size_t step = (rays.size() + most - 1) / most;
  ValidRays some;
  for (std::size_t i = 0; i < rays.size(); i += step) {
    some.angle_rad.push_back(rays.angle_rad[i]);
    some.range_m.push_back(rays.range_m[i]);
    if (!rays.time_s.empty()) some.time_s.push_back(rays.time_s[i]);
  }
  return some;
}

}  // namespace

void RunStatistics::Add(std::int64_t utime, const ValidRays& rays) {
  if (rays.size() == 0) return;
  Sampled* sampled = FindSampled(utime);
  if (sampled && !sampled->rays) sampled->rays = Thin(rays, constants_.most_rays);
}

void RunStatistics::Add(const ScanMatch& match) {
  const ScanOutcome outcome = OutcomeOf(match);
  if (values_.counts.scans() == 0) values_.first_utime = match.utime;
  values_.counts.Add(match);
  if (match.state != MatchState::kFirst && match.map_version == 0) values_.finished_map = true;
  const bool was_lost = num_unmatched_in_a_row_ > 0;
  CountUnmatched(outcome);
  if (outcome != ScanOutcome::kOnMap) {
    if (const auto track = tracks_.find(match.trajectory); track != tracks_.end()) track->second.previous.reset();
    return;
  }
  Track& track = tracks_.try_emplace(match.trajectory, Track{{}, match, {}}).first->second;
  if (match.state == MatchState::kDegenerate) ++values_.degenerate;
  if (match.state != MatchState::kFirst) {
    fitness_sum_ += match.fitness;
    ++num_fitnesses_;
  }
  LengthenPath(match, track);
  LookHowFar(match, track.first);
  if (Sampled* sampled = FindSampled(match.utime)) {
    sampled->T_map_laser = match.T_map_laser;
    sampled->twist = match.twist;
    sampled->path_m = values_.path_m;
    sampled->degenerate = match.state == MatchState::kDegenerate;
  }
  if (track.previous) AddStep(*track.previous, match);
  if (was_lost && last_on_map_) LookForJump(*last_on_map_, match);
  track.previous = last_on_map_ = match;
}

void RunStatistics::ForgetRays(std::int64_t utime) {
  if (Sampled* sampled = FindSampled(utime)) sampled->rays.reset();
}

void RunStatistics::ForgetMatches() {
  auto sampled = std::move(sampled_);
  for (auto& [hash, each] : sampled) each.T_map_laser.reset();
  const bool of_keyframes = of_keyframes_;
  *this = RunStatistics(constants_);
  of_keyframes_ = of_keyframes;
  sampled_ = std::move(sampled);
}

RunStatistics::Values RunStatistics::values() const {
  Values values = values_;
  if (of_keyframes_) values.far_steps = 0;
  if (num_fitnesses_ > 0) values.mean_fitness = fitness_sum_ / static_cast<double>(num_fitnesses_);
  values.turns_by_odometry = turns_.Compute(constants_.least_turns_rad2);
  values.ways_by_odometry = ways_.Compute(constants_.least_ways_m2);
  return values;
}

std::optional<double> RunStatistics::ComputeMeanAgreement(const ByteMap& map) const {
  double sum = 0.0;
  std::size_t num = 0;
  std::size_t num_asked = 0;
  for (const auto& [hash, sampled] : sampled_) {
    if (!sampled.rays || !sampled.T_map_laser) continue;
    if (num_asked++ == constants_.most_asked) break;
    const ValidRays rays = Deskew(Thin(*sampled.rays, constants_.most_rays_asked), sampled.twist);
    sum += CountRays(map, ComputeHits(rays), *sampled.T_map_laser).fits;
    ++num;
  }
  if (num < constants_.least_asked) return std::nullopt;
  return sum / static_cast<double>(num);
}

SelfContradiction RunStatistics::FindContradiction() const {
  std::vector<PlacedRays> scans;
  for (const auto& [hash, sampled] : sampled_) {
    if (!sampled.rays || !sampled.T_map_laser || sampled.degenerate) continue;
    scans.push_back({Deskew(*sampled.rays, sampled.twist), *sampled.T_map_laser, sampled.path_m});
  }
  std::ranges::stable_sort(scans, {}, &PlacedRays::path_m);
  return FindSelfContradiction(scans, constants_.contradiction);
}

/// nullptr if the scan is not in the sample. What has left it never comes back: the largest hash in it only falls.
RunStatistics::Sampled* RunStatistics::FindSampled(std::int64_t utime) {
  const std::uint64_t hash = Random(0, static_cast<std::uint64_t>(utime)).Next();
  const auto found = sampled_.find(hash);
  if (found != sampled_.end()) return &found->second;
  if (sampled_.size() == constants_.most_sampled) {
    const auto last = std::prev(sampled_.end());
    if (hash > last->first) return nullptr;
    sampled_.erase(last);
  }
  return &sampled_[hash];
}

/// What floats is not lost.
void RunStatistics::CountUnmatched(ScanOutcome outcome) {
  const bool is_unmatched = outcome == ScanOutcome::kLost || outcome == ScanOutcome::kWithoutRays;
  num_unmatched_in_a_row_ = is_unmatched ? num_unmatched_in_a_row_ + 1 : 0;
  values_.longest_unmatched = std::max(values_.longest_unmatched, num_unmatched_in_a_row_);
}

/// By steps that are longer than what a robot that stands seems to move.
void RunStatistics::LengthenPath(const ScanMatch& match, Track& track) {
  const double step_m = track.T_map_on_path ? Distance(*track.T_map_on_path, match.T_map_laser) : 0.0;
  if (track.T_map_on_path && step_m < constants_.path_step_m) return;
  values_.path_m += step_m;
  track.T_map_on_path = match.T_map_laser;
}

void RunStatistics::LookHowFar(const ScanMatch& match, const ScanMatch& first) {
  const Pose2 motion = Inverse(first.T_map_laser) * match.T_map_laser;
  values_.furthest_m = std::max(values_.furthest_m, Length(motion));
  values_.furthest_rad = std::max(values_.furthest_rad, std::abs(motion.yaw_rad));
}

void RunStatistics::AddStep(const ScanMatch& from, const ScanMatch& to) {
  const Pose2 motion = Inverse(from.T_map_laser) * to.T_map_laser;
  ++values_.steps;
  const bool is_far =
      std::hypot(motion.x_m, motion.y_m) > constants_.far_m || std::abs(motion.yaw_rad) > constants_.far_rad;
  if (is_far && !to.by_wheels) ++values_.far_steps;  // wheels that are believed tell where to look
  LookForJump(from, to);
  if (!from.T_odom_robot || !to.T_odom_robot) return;
  const Pose2 wheels = Inverse(*from.T_odom_robot) * *to.T_odom_robot;
  turns_.product += wheels.yaw_rad * motion.yaw_rad;
  turns_.odometry += wheels.yaw_rad * wheels.yaw_rad;
  turns_.laser += motion.yaw_rad * motion.yaw_rad;
  ways_.product += wheels.x_m * motion.x_m + wheels.y_m * motion.y_m;
  ways_.odometry += wheels.x_m * wheels.x_m + wheels.y_m * wheels.y_m;
  ways_.laser += motion.x_m * motion.x_m + motion.y_m * motion.y_m;
}

void RunStatistics::LookForJump(const ScanMatch& from, const ScanMatch& to) {
  const double step_m = Distance(from.T_map_laser, to.T_map_laser);
  const double time_s = 1e-6 * std::abs(static_cast<double>(to.utime) - static_cast<double>(from.utime));
  if (step_m <= std::max(constants_.jump_m, constants_.jump_m_s * time_s)) return;
  if (step_m <= values_.longest_jump_m) return;
  values_.longest_jump_m = step_m;
  values_.longest_jump_ends = {to.T_map_laser.x_m, to.T_map_laser.y_m};
}

std::optional<double> RunStatistics::Correlation::Compute(double least) const {
  if (odometry < least || laser < least) return std::nullopt;
  return product / std::sqrt(odometry * laser);
}

}  // namespace crsm
