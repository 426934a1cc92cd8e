#include "common/match/match_scan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/match/contradiction.hpp"
#include "common/match/guess_covariance.hpp"
#include "common/match/motion_prediction.hpp"
#include "common/match/sweep.hpp"
#include "common/math/median.hpp"
#include "common/scan/clock_restart.hpp"
#include "common/scan/deskew.hpp"

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
bool IsGap(const TrackingState& tracking, std::int64_t utime, double gap_max_s) {
  constexpr double kTimesUsual = 8.0;  // a logger that takes a scan a metre has no gaps, however slow the robot is
  const Periods periods = FindPeriods(tracking, utime);
  return gap_max_s > 0.0 && periods.last_s > std::max(gap_max_s, kTimesUsual * periods.usual_s);
}

/// Whether a scan fits where the last one was taken, as well as scans do as a rule.
bool StoodStill(const ScanMatch& match, const TrackingState& tracking) {
  constexpr double kStill_m = 0.3;
  constexpr double kStill_rad = 0.2;
  constexpr double kAsUsual = 0.9;
  const Pose2 motion = Inverse(tracking.recent().back().T_map_laser) * match.T_map_laser;
  return match.state != MatchState::kLost && Length(motion) < kStill_m && std::abs(motion.yaw_rad) < kStill_rad &&
         match.fitness >= kAsUsual * tracking.baseline_fitness();
}

/// Whether a scan is found again after others were lost. In a window that has grown something fits by chance, and what
/// lies beyond the map is not asked for: a wrong place costs the map, a new trajectory only time.
bool IsConvincing(const ScanMatch& match, const TrackingState& tracking) {
  constexpr double kConvincing = 0.6;  // of the baseline fitness
  return match.state == MatchState::kLost || match.fitness >= kConvincing * tracking.baseline_fitness();
}

/// Whether the map contradicts a scan that fits it much worse than scans do as a rule: the robot was carried, and
/// stands where something fits by chance. No scan of intel, fr079, aces and killian is so bad: a robot that drives into
/// a niche of aces has 0.416. Of six robots that were carried in aces and killian to where a scan fits by chance, four
/// had more than 0.38.
bool IsContradicted(const Matcher& matcher, const CriticalRays& scan, const ScanMatch& match,
                    const TrackingState& tracking) {
  constexpr double kMuchWorse = 0.75;  // of the baseline fitness
  constexpr double kContradicted = 0.42;
  if (match.state == MatchState::kLost || tracking.fitnesses().size() < TrackingState::kUsual) return false;
  if (match.fitness >= kMuchWorse * tracking.baseline_fitness()) return false;
  const Eigen::Matrix2Xd hits_m = ComputeHits(Deskew(scan, match.twist).rays);
  return ComputeContradiction(matcher.map(), hits_m, match.T_map_laser) > kContradicted;
}

ScanMatch Lose(ScanMatch match, const Pose2& guess) {
  match.state = MatchState::kLost;
  match.T_map_laser = guess;
  match.covariance = {};
  match.degenerate_axis = {};
  return match;
}

bool HasEnoughRays(const CriticalRays& scan) {
  constexpr std::size_t kFewest = 20;  // less is no place to begin a map at
  return scan.rays.size() >= kFewest;
}

/// After how many lost scans in a row a trajectory ends. One on which hardly anything was matched yet is no loss: there
/// was a hand before the laser, say.
std::int64_t FindPatience(const TrackingState& tracking, int lost_scans_max) {
  return tracking.fitnesses().size() < kHardlyMatched ? std::min(lost_scans_max, 1) : lost_scans_max;
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
ScanMatch BeginByWheels(const ScanMatch& match, const TrackingState& tracking) {
  constexpr double kStands_m = 0.05;
  constexpr double kStands_rad = 0.05;
  constexpr double kLifted_s = 2.0;
  const auto way = FindWayByWheels(tracking.recent(), match.by_wheels);
  ScanMatch first = Begin(match, match.T_map_laser);
  const bool stands = way && Length(way->T_from_to) < kStands_m && std::abs(way->T_from_to.yaw_rad) < kStands_rad;
  const bool is_carried = stands && FindSecondsLost(tracking.recent(), match.utime) >= kLifted_s;
  if (way && !is_carried) first.by_wheels = match.by_wheels;
  return first;
}

/// Where the known map shows a scan to be, far from the last one. Nearby a guess is as good, and promises nothing.
std::optional<Pose2> FindFarAway(const Matcher& matcher, const CriticalRays& scan, const Pose2& T_map_last) {
  const auto found = matcher.Locate(scan);
  return found && Distance(*found, T_map_last) > kGuessWindow.most_m ? found : std::nullopt;
}

/// As of MatchScan; what a guess is worth is still to be said.
ScanMatch MatchOrBegin(const Matcher& matcher, const CriticalRays& scan, const TrackingState& tracking,
                       const std::optional<Pose2>& T_odom_robot, const LoopParameters& parameters) {
  ScanMatch match = MatchSweep(matcher, scan, tracking, T_odom_robot);
  match.by_wheels = tracking.wheels().Predict(tracking.recent(), scan.utime, match.T_odom_robot);
  match.trajectory = tracking.trajectory();
  match.floating = tracking.floating();
  if (!parameters.loops || tracking.empty() || tracking.on_finished_map()) return match;
  if (tracking.onset() == Onset::kNear || tracking.onset() == Onset::kAnywhere) {
    return HasEnoughRays(scan) ? Begin(match, tracking.T_map_guess()) : Lose(match, tracking.T_map_guess());
  }
  if (!HasEnoughRays(scan)) return match;
  const ScanMatch& last = tracking.recent().back();
  const bool is_convincing = tracking.num_lost() == 0 || IsConvincing(match, tracking);
  if (!is_convincing || IsContradicted(matcher, scan, match, tracking)) match = Lose(match, GuessByWheels(match, last));
  const bool lost_for_long = match.state == MatchState::kLost && parameters.lost_scans_max > 0 &&
                             tracking.num_lost() + 1 >= FindPatience(tracking, parameters.lost_scans_max);
  const bool resumed_elsewhere = match.state == MatchState::kLost && tracking.onset() == Onset::kResumed;
  const bool is_gap = IsGap(tracking, scan.utime, parameters.gap_max_s) && !match.by_wheels;
  const bool broken = (is_gap || HasClockRestarted(last.utime, scan.utime)) && !StoodStill(match, tracking);
  if (lost_for_long && match.by_wheels) return BeginByWheels(match, tracking);
  if (!lost_for_long && !broken && !resumed_elsewhere) return match;
  const Pose2 guess = lost_for_long ? GuessOnward(tracking.recent(), scan.utime) : last.T_map_laser;
  const auto found = FindFarAway(matcher, scan, last.T_map_laser);
  ScanMatch first = Begin(match, found.value_or(guess));
  if (found) first.covariance = kUnknownCovariance;
  return first;
}

}  // namespace

ScanMatch MatchScan(const Matcher& matcher, const CriticalRays& scan, const TrackingState& tracking,
                    const std::optional<Pose2>& T_odom_robot, const LoopParameters& parameters) {
  ScanMatch match = MatchOrBegin(matcher, scan, tracking, T_odom_robot, parameters);
  const bool begins_amid = match.state == MatchState::kFirst && match.trajectory > 0;
  const bool is_guess = match.state == MatchState::kLost || (begins_amid && match.covariance[0] == 0.0);
  if (is_guess) match.covariance = ComputeGuessCovariance(match, tracking);
  return match;
}

}  // namespace crsm
