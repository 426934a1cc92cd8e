#include "common/match/match_scan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/match/guess/guess_covariance.hpp"
#include "common/match/guess/motion_prediction.hpp"
#include "common/match/sweep.hpp"
#include "common/math/median.hpp"
#include "common/scan/clock_restart.hpp"

namespace crsm {
namespace {

/// Time from the last scan to this one [s], and what is usual; negative where a clock steps back.
struct Periods {
  double last_s;
  double usual_s;  ///< median of those that are remembered
};

Periods FindPeriods(const TrackingState& tracking, std::int64_t utime) {
  const auto recent = tracking.recent();
  std::vector<double> periods_s;
  for (std::size_t i = 1; i < recent.size(); ++i) {
    periods_s.push_back(1e-6 * std::abs(static_cast<double>(recent[i].utime - recent[i - 1].utime)));
  }
  return {1e-6 * static_cast<double>(utime - recent.back().utime), FindMedian(std::move(periods_s))};
}

/// Whether so much time has passed that the robot may be anywhere.
bool IsGap(const TrackingState& tracking, std::int64_t utime, const MatchConstants::Break& constants) {
  const Periods periods = FindPeriods(tracking, utime);
  return periods.last_s > std::max(constants.gap_max_s, constants.gap_periods * periods.usual_s);
}

/// Whether a match is as near to where the last scan was taken as the first search looks.
bool IsNearLast(const ScanMatch& match, const TrackingState& tracking, const MatchConstants::Search& constants) {
  const Pose2 motion = Inverse(tracking.recent().back().T_map_laser) * match.T_map_laser;
  return Length(motion) < constants.window_m && std::abs(motion.yaw_rad) < constants.window_rad;
}

/// Whether a scan fits where the last one was taken, as well as scans do as a rule.
bool StoodStill(const ScanMatch& match, const TrackingState& tracking, const MatchConstants& constants) {
  return match.state != MatchState::kLost && IsNearLast(match, tracking, constants.search) &&
         match.fitness >= constants.breaks.stood_still_fitness * tracking.baseline_fitness();
}

/// Whether a scan is found again after others were lost. In a window that has grown something fits by chance, and what
/// lies beyond the map is not asked for: a wrong place costs the map, a new trajectory only time. What is as near as
/// the first search looks needs no such proof.
bool IsConvincing(const ScanMatch& match, const TrackingState& tracking, const MatchConstants& constants) {
  return match.state == MatchState::kLost || IsNearLast(match, tracking, constants.search) ||
         match.fitness >= constants.breaks.found_again_fitness * tracking.baseline_fitness();
}

ScanMatch Lose(ScanMatch match, const Pose2& guess) {
  match.state = MatchState::kLost;
  match.T_map_laser = guess;
  match.covariance = {};
  match.degenerate_axis = {};
  return match;
}

/// Where the wheels lead from the last scan; there where they are not believed.
Pose2 GuessByWheels(const ScanMatch& match, const ScanMatch& last) {
  return match.by_wheels ? last.T_map_laser * match.by_wheels->T_from_to : last.T_map_laser;
}

/// A new trajectory, where the robot is guessed to be or was found on the known map: one scan proves nothing, so it
/// floats all the same. While the map is empty it is still the first of all.
ScanMatch Begin(const ScanMatch& match, const Pose2& guess) {
  const bool is_first_of_all = match.state == MatchState::kFirst;
  ScanMatch first;
  first.utime = match.utime;
  first.T_map_laser = guess;
  first.evaluations = match.evaluations;
  first.num_critical = match.num_critical;
  first.T_odom_robot = match.T_odom_robot;
  first.trajectory = is_first_of_all ? match.trajectory : match.trajectory + 1;
  first.floating = !is_first_of_all;
  return first;
}

/// From the newest of some scans that was matched [s].
double FindSecondsLost(std::span<const ScanMatch> recent, std::int64_t utime) {
  const auto matched = std::find_if(recent.rbegin(), recent.rend(),
                                    [](const ScanMatch& match) { return match.state != MatchState::kLost; });
  const ScanMatch& last = matched == recent.rend() ? recent.front() : *matched;
  return 1e-6 * static_cast<double>(utime - last.utime);
}

/// The same where the wheels lead on from the last scan that was matched. A robot whose wheels stand while its scans
/// are lost is carried, unless that is faster than anyone lifts it: then something stands before the laser.
ScanMatch BeginByWheels(const ScanMatch& match, const TrackingState& tracking,
                        const MatchConstants::Wheels& constants) {
  const auto way = FindWayByWheels(tracking.recent(), match.by_wheels);
  ScanMatch first = Begin(match, match.T_map_laser);
  const bool stands = way && Length(way->T_from_to) + std::abs(way->T_from_to.yaw_rad) < constants.stands_m;
  const bool is_carried = stands && FindSecondsLost(tracking.recent(), match.utime) >= constants.lifted_s;
  if (way && !is_carried) first.by_wheels = match.by_wheels;
  return first;
}

/// Where the known map shows a scan to be, far from the last one. Nearby a guess is as good, and promises nothing.
std::optional<Pose2> FindFarAway(const Matcher& matcher, const CriticalRays& scan, const Pose2& T_map_last,
                                 double nearby_m) {
  const auto found = matcher.Locate(scan);
  return found && Distance(*found, T_map_last) > nearby_m ? found : std::nullopt;
}

/// As of MatchScan; what a guess is worth is still to be said.
ScanMatch MatchOrBegin(const Matcher& matcher, const CriticalRays& scan, const TrackingState& tracking,
                       const std::optional<Pose2>& T_odom_robot, const MatchOptions& options) {
  const MatchConstants::Break& breaks = options.constants.breaks;
  const bool has_enough_rays = std::ssize(scan.rays.range_m) >= breaks.fewest_rays;
  ScanMatch match = MatchSweep(matcher, scan, tracking, T_odom_robot, options.constants);
  match.by_wheels = tracking.wheels().Predict(tracking.recent(), scan.utime, match.T_odom_robot);
  match.trajectory = tracking.trajectory();
  match.floating = tracking.floating();
  if (!options.loops || tracking.empty() || tracking.on_finished_map()) return match;
  if (tracking.onset() == Onset::kNear || tracking.onset() == Onset::kAnywhere) {
    return has_enough_rays ? Begin(match, tracking.T_map_guess()) : Lose(match, tracking.T_map_guess());
  }
  if (!has_enough_rays) return match;
  const ScanMatch& last = tracking.recent().back();
  const bool is_convincing = tracking.num_lost() == 0 || IsConvincing(match, tracking, options.constants);
  if (!is_convincing) match = Lose(match, GuessByWheels(match, last));
  const bool lost_for_long = match.state == MatchState::kLost && tracking.num_lost() + 1 >= breaks.lost_scans_max;
  const bool resumed_elsewhere = match.state == MatchState::kLost && tracking.onset() == Onset::kResumed;
  const bool is_gap = IsGap(tracking, scan.utime, breaks) && !match.by_wheels;
  const bool broken =
      (is_gap || HasClockRestarted(last.utime, scan.utime)) && !StoodStill(match, tracking, options.constants);
  if (lost_for_long && match.by_wheels) return BeginByWheels(match, tracking, options.constants.wheels);
  if (!lost_for_long && !broken && !resumed_elsewhere) return match;
  const auto found = FindFarAway(matcher, scan, last.T_map_laser, options.constants.guess_window.most_m);
  ScanMatch first = Begin(match, found.value_or(last.T_map_laser));
  if (found) first.covariance = kUnknownCovariance;
  return first;
}

}  // namespace

ScanMatch MatchScan(const Matcher& matcher, const CriticalRays& scan, const TrackingState& tracking,
                    const std::optional<Pose2>& T_odom_robot, const MatchOptions& options) {
  ScanMatch match = MatchOrBegin(matcher, scan, tracking, T_odom_robot, options);
  const bool begins_amid = match.state == MatchState::kFirst && match.trajectory > 0;
  const bool is_guess = match.state == MatchState::kLost || (begins_amid && match.covariance[0] == 0.0);
  if (is_guess) match.covariance = ComputeGuessCovariance(match, tracking, options.constants.guess_window);
  return match;
}

}  // namespace crsm
