#include "common/match/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/scan/deskew.hpp"

namespace crsm {
namespace {

/// How the laser moved on the way to a match, as seen from there. Nothing if that is not known, or too long ago.
std::optional<Twist> FindTwist(const ScanMatch& from, const ScanMatch& to, const MatchConstants& constants) {
  const double elapsed_s = 1e-6 * static_cast<double>(to.utime - from.utime);
  if (from.state == MatchState::kLost || to.state == MatchState::kLost) return std::nullopt;
  if (to.state == MatchState::kFirst) return std::nullopt;  // its pose is a guess
  if (elapsed_s <= 0.0 || elapsed_s > constants.map_search.close_s) return std::nullopt;
  const Pose2 back = Inverse(to.T_map_laser) * from.T_map_laser;
  const Twist twist{-back.x_m / elapsed_s, -back.y_m / elapsed_s, -back.yaw_rad / elapsed_s};
  const double fastest = std::max({std::abs(twist.x_m_s), std::abs(twist.y_m_s), std::abs(twist.yaw_rad_s)});
  return fastest <= kFastest ? std::optional(twist) : std::nullopt;
}

/// As the laser moved last; over scans that were lost it goes on so.
Twist PredictTwist(const TrackingState& tracking, const MatchConstants& constants) {
  const auto recent = tracking.recent();
  if (recent.size() < 2 || tracking.num_lost() >= constants.acceptance.patience) return {};
  return FindTwist(recent[recent.size() - 2], recent.back(), constants).value_or(recent.back().twist);
}

/// How far apart two twists bring the beam that they move most [m]; turns count at a lever from the laser.
double ComputeDifference(const Twist& a, const Twist& b, double sweep_s, double lever_m) {
  return sweep_s *
         (std::abs(a.x_m_s - b.x_m_s) + std::abs(a.y_m_s - b.y_m_s) + lever_m * std::abs(a.yaw_rad_s - b.yaw_rad_s));
}

/// Matches a sweep that is deskewed by a twist, and again by the twist that this brings, until they agree.
class SweepMatcher {
 public:
  SweepMatcher(const Matcher& matcher, const CriticalRays& scan, const TrackingState& tracking,
               const std::optional<Pose2>& T_odom_robot, const MatchConstants& constants)
      : matcher_(matcher), scan_(scan), tracking_(tracking), T_odom_robot_(T_odom_robot), constants_(constants) {
    const auto [first, last] = std::minmax_element(scan.rays.time_s.begin(), scan.rays.time_s.end());
    sweep_s_ = static_cast<double>(*last) - *first;
  }

  ScanMatch MatchFrom(Twist twist) const {
    ScanMatch best = MatchNear(twist);
    for (int i = 1; i < constants_.sweep.most_matches && !tracking_.recent().empty(); ++i) {
      const auto matched = FindTwist(tracking_.recent().back(), best, constants_);
      if (!matched) break;
      if (ComputeDifference(*matched, best.twist, sweep_s_, constants_.sweep.lever_m) < constants_.tracking.match_m)
        break;
      const ScanMatch next = MatchNear(*matched);
      if (next.state == MatchState::kLost || next.fitness < best.fitness) break;
      best = next;
    }
    return best;
  }

  /// With all that the matcher does where nothing fits.
  ScanMatch MatchAll(const Twist& twist) const { return MatchBy(&Matcher::Match, twist); }

  double sweep_s() const { return sweep_s_; }

 private:
  ScanMatch MatchNear(const Twist& twist) const { return MatchBy(&Matcher::MatchNear, twist); }
  ScanMatch MatchBy(decltype(&Matcher::Match) match_by, const Twist& twist) const {
    ScanMatch match = (matcher_.*match_by)(Deskew(scan_, twist), tracking_, T_odom_robot_);
    match.twist = twist;
    return match;
  }

  const Matcher& matcher_;
  const CriticalRays& scan_;
  const TrackingState& tracking_;
  const std::optional<Pose2>& T_odom_robot_;
  const MatchConstants& constants_;
  double sweep_s_;
};

}  // namespace

ScanMatch MatchSweep(const Matcher& matcher, const CriticalRays& scan, const TrackingState& tracking,
                     const std::optional<Pose2>& T_odom_robot, const MatchConstants& constants) {
  if (scan.rays.time_s.empty()) return matcher.Match(scan, tracking, T_odom_robot);
  const SweepMatcher sweep(matcher, scan, tracking, T_odom_robot, constants);
  const auto IsGood = [&](const ScanMatch& match) {
    return match.state != MatchState::kLost && match.fitness >= constants.acceptance.good * tracking.baseline_fitness();
  };
  const auto IsBetter = [](const ScanMatch& one, const ScanMatch& other) {
    const bool one_lost = one.state == MatchState::kLost;
    const bool other_lost = other.state == MatchState::kLost;
    return one_lost == other_lost ? one.fitness > other.fitness : other_lost;
  };
  const Twist predicted = PredictTwist(tracking, constants);
  if (tracking.recent().empty() || tracking.num_lost() >= constants.acceptance.patience)
    return sweep.MatchAll(predicted);
  ScanMatch best = sweep.MatchFrom(predicted);
  std::vector<Twist> others;
  for (const double steps : {0.0, 1.0, -1.0, 2.0, -2.0}) {
    const double turn_rad = steps * constants.search.window_rad;
    if (std::abs(turn_rad) > constants.sweep.fastest_turn_rad_s * sweep.sweep_s()) continue;
    const Twist twist{0.0, 0.0, turn_rad == 0.0 ? 0.0 : turn_rad / sweep.sweep_s()};
    if (twist != predicted) others.push_back(twist);
  }
  for (const Twist& twist : others) {
    if (IsGood(best)) return best;
    const ScanMatch other = sweep.MatchFrom(twist);
    if (IsBetter(other, best)) best = other;
  }
  // Nothing fits near the guess: the rare case, and the dear one.
  others.insert(others.begin(), {best.twist, predicted});
  for (auto twist = others.begin(); best.state == MatchState::kLost && twist != others.end(); ++twist) {
    if (std::find(others.begin(), twist, *twist) != twist) continue;  // once more
    const ScanMatch other = sweep.MatchAll(*twist);
    if (IsBetter(other, best)) best = other;
  }
  return best;
}

}  // namespace crsm
