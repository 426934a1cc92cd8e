#include "common/match/motion_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace crsm {

Pose2 PredictPose(std::span<const ScanMatch> recent, const MatchConstants::Prediction& constants) {
  // The way is the mean of some motions, because along a corridor no single one is known well. Where nothing seen holds
  // the position, it is the mean of all that are remembered and not too old: an error of one motion, taken over into
  // the next ones, would grow until the robot seemed to stand. The turn is the last one: it is always known well, and
  // soon another.
  const bool is_degenerate = recent.back().state == MatchState::kDegenerate;
  const std::size_t num_motions = is_degenerate ? constants.motions_degenerate : constants.motions;
  Pose2 sum;
  std::size_t num = 0;
  for (; num < num_motions && num + 1 < recent.size(); ++num) {
    const ScanMatch& to = recent[recent.size() - 1 - num];
    const ScanMatch& from = recent[recent.size() - 2 - num];
    if (num >= constants.motions && recent.back().utime - from.utime > constants.oldest_us) break;
    if (!IsMotionMatched(from, to)) break;
    const Pose2 motion = Inverse(from.T_map_laser) * to.T_map_laser;
    sum.x_m += motion.x_m;
    sum.y_m += motion.y_m;
    if (num == 0) sum.yaw_rad = motion.yaw_rad;
  }
  if (num == 0) return recent.back().T_map_laser;
  const double share = 1.0 / static_cast<double>(num);
  return recent.back().T_map_laser * Pose2{share * sum.x_m, share * sum.y_m, sum.yaw_rad};
}

double ComputeSteadiness(std::span<const ScanMatch> recent, std::int64_t utime,
                         const MatchConstants::MotionPrior& constants) {
  if (recent.empty()) return 1.0;
  const double elapsed_s = 1e-6 * static_cast<double>(utime - recent.back().utime);
  return elapsed_s <= constants.steady_s ? 1.0 : std::pow(constants.steady_s / elapsed_s, 2);
}

std::optional<Pose2> ContinueMotion(std::span<const ScanMatch> recent, const MatchConstants::Prediction& constants) {
  std::size_t num_lost = 0;
  while (num_lost < recent.size() && recent[recent.size() - 1 - num_lost].state == MatchState::kLost) ++num_lost;
  if (num_lost == 0 || num_lost > constants.lost_scans_max || recent.size() < num_lost + 2) return std::nullopt;
  const auto matched = recent.first(recent.size() - num_lost);
  const Pose2 motion = Inverse(matched.back().T_map_laser) * PredictPose(matched, constants);
  Pose2 pose = matched.back().T_map_laser;
  for (std::size_t i = 0; i <= num_lost; ++i) pose = pose * motion;
  return pose;
}

Pose2 GuessOnward(std::span<const ScanMatch> recent, std::int64_t utime, const MatchConstants::Prediction& constants) {
  const auto IsLost = [](const ScanMatch& match) { return match.state == MatchState::kLost; };
  const auto last = std::find_if_not(recent.rbegin(), recent.rend(), IsLost);
  const Pose2& guess = recent.back().T_map_laser;
  if (last == recent.rend() || last->state == MatchState::kFirst) return guess;
  const auto before = std::next(last);
  if (before == recent.rend() || IsLost(*before)) return guess;
  const double period_s = 1e-6 * static_cast<double>(last->utime - before->utime);
  const double since_s = 1e-6 * static_cast<double>(utime - last->utime);
  if (period_s <= 0.0 || since_s <= 0.0) return guess;
  const Pose2 motion = Inverse(before->T_map_laser) * last->T_map_laser;
  const double share = std::min(since_s, constants.onward_max_s) / period_s / constants.onward_steps;
  Pose2 onward = last->T_map_laser;
  for (int i = 0; i < constants.onward_steps; ++i) {
    onward = onward * Pose2{share * motion.x_m, share * motion.y_m, share * constants.onward_turn * motion.yaw_rad};
  }
  return onward;
}

}  // namespace crsm
