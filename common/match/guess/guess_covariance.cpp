#include "common/match/guess/guess_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "common/math/trigonometry.hpp"
#include "common/scan/clock_restart.hpp"

namespace crsm {
namespace {

/// Standard deviations, or speeds.
struct Spread {
  double m;
  double rad;
};

const double kMost_m = 0.5 * std::sqrt(kUnknownVariance);  // half of what is said where nothing is known
constexpr double kMost_rad = kPi / 1.7320508075688772;     // a heading that may be any: uniform from -pi to pi

/// Per second, over the matches that are remembered and follow each other; 0 where there are none.
Spread FindSpeed(std::span<const ScanMatch> recent) {
  Spread way{0.0, 0.0};
  double time_s = 0.0;
  for (std::size_t i = 1; i < recent.size(); ++i) {
    const ScanMatch& from = recent[i - 1];
    const ScanMatch& to = recent[i];
    if (!IsMotionMatched(from, to) || to.utime <= from.utime) continue;
    const Pose2 motion = Inverse(from.T_map_laser) * to.T_map_laser;
    way.m += Length(motion);
    way.rad += std::abs(motion.yaw_rad);
    time_s += 1e-6 * static_cast<double>(to.utime - from.utime);
  }
  return time_s > 0.0 ? Spread{way.m / time_s, way.rad / time_s} : Spread{0.0, 0.0};
}

/// Since the last scan.
Spread FindGrowth(const ScanMatch& guess, std::span<const ScanMatch> recent,
                  const MatchConstants::GuessWindow& constants) {
  const ScanMatch& last = recent.back();
  if (guess.by_wheels) return {guess.by_wheels->sigma_m, guess.by_wheels->sigma_rad};
  if (HasClockRestarted(last.utime, guess.utime)) return {kMost_m, kMost_rad};
  const double elapsed_s = std::max(0.0, 1e-6 * static_cast<double>(guess.utime - last.utime));
  const Spread speed = FindSpeed(recent);
  return {elapsed_s * std::max(constants.sigma_share * constants.m_per_s, speed.m),
          elapsed_s * std::max(constants.sigma_share * constants.rad_per_s, speed.rad)};
}

}  // namespace

std::array<double, 6> ComputeGuessCovariance(const ScanMatch& guess, const TrackingState& tracking,
                                             const MatchConstants::GuessWindow& constants) {
  const bool is_told = tracking.onset() == Onset::kNear && guess.T_map_laser == tracking.T_map_guess();
  const bool another_drive = tracking.onset() == Onset::kNear || tracking.onset() == Onset::kAnywhere;
  const bool never_matched = tracking.on_finished_map() && tracking.fitnesses().empty();
  if (tracking.empty() || never_matched || (another_drive && !is_told)) {
    return kUnknownCovariance;
  }
  Spread sigma{constants.sigma_share * constants.m, constants.sigma_share * constants.rad};
  if (!is_told) {
    const ScanMatch& last = tracking.recent().back();
    if (last.state == MatchState::kLost) sigma = {std::sqrt(last.covariance[0]), std::sqrt(last.covariance[5])};
    const Spread growth = FindGrowth(guess, tracking.recent(), constants);
    sigma.m += growth.m;
    sigma.rad += growth.rad;
  }
  sigma = {std::min(sigma.m, kMost_m), std::min(sigma.rad, kMost_rad)};
  return {sigma.m * sigma.m, 0.0, 0.0, sigma.m * sigma.m, 0.0, sigma.rad * sigma.rad};
}

}  // namespace crsm
