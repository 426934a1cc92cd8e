#include "common/match/guess/guess_covariance.hpp"

#include <cmath>

#include "catch.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;

ScanMatch Guess(std::int64_t utime, const Pose2& pose = {}, MatchState state = MatchState::kLost) {
  ScanMatch match;
  match.utime = utime;
  match.T_map_laser = pose;
  match.state = state;
  return match;
}

/// After ten matches, one each second, the last of them at 9 s: `speed` metres and radians apart.
TrackingState Driven(double speed_m_s, double speed_rad_s = 0.0) {
  TrackingState tracking;
  for (int i = 0; i < 10; ++i) {
    tracking.Add(Guess(i * kSecond_us, {speed_m_s * i, 0.0, speed_rad_s * i}, MatchState::kOk));
  }
  return tracking;
}

/// Loses scans at the pose of the last match.
void Lose(TrackingState& tracking, int num, std::int64_t period_us) {
  for (int i = 0; i < num; ++i) {
    const bool first = tracking.empty();
    ScanMatch lost = Guess(first ? 0 : tracking.recent().back().utime + period_us,
                           first ? Pose2{} : tracking.recent().back().T_map_laser);
    lost.covariance = ComputeGuessCovariance(lost, tracking);
    tracking.Add(lost);
  }
}

void CheckSigmas(const std::array<double, 6>& covariance, double m, double rad) {
  CHECK(std::sqrt(covariance[0]) == Approx(m));
  CHECK(covariance[0] == covariance[3]);
  CHECK(std::sqrt(covariance[5]) == Approx(rad));
  for (const std::size_t between : {1, 2, 4}) CHECK(covariance[between] == 0.0);
}

}  // namespace

TEST_CASE("a guess is worth half of the window at first, and less with every second, as fast as the robot was") {
  const std::int64_t since_us = GENERATE(0, 1, 4) * kSecond_us;
  const double since_s = 1e-6 * static_cast<double>(since_us);
  CheckSigmas(ComputeGuessCovariance(Guess(9 * kSecond_us + since_us), Driven(0.0)), 0.35 + 0.175 * since_s,
              0.1 + 0.05 * since_s);
  CheckSigmas(ComputeGuessCovariance(Guess(9 * kSecond_us + since_us), Driven(0.8, 0.0)), 0.35 + 0.8 * since_s,
              0.1 + 0.05 * since_s);
  CheckSigmas(ComputeGuessCovariance(Guess(9 * kSecond_us + since_us), Driven(0.0, -0.25)), 0.35 + 0.175 * since_s,
              0.1 + 0.25 * since_s);
}

TEST_CASE("it makes no difference how many scans were lost in the time, also more than are remembered") {
  for (const int num : {1, 2, 7, 30}) {
    TrackingState tracking = Driven(0.0);
    Lose(tracking, num, 3 * kSecond_us / num);
    CheckSigmas(tracking.recent().back().covariance, 0.35 + 3 * 0.175, 0.1 + 3 * 0.05);
  }
  TrackingState fast = Driven(0.8);
  Lose(fast, 6, kSecond_us / 2);
  CheckSigmas(fast.recent().back().covariance, 0.35 + 3 * 0.8, 0.1 + 3 * 0.05);
}

TEST_CASE("where nobody knows the time between, or it is long, a guess says hardly anything, but not nothing") {
  for (const std::int64_t utime : {-1 * kSecond_us, 3'600 * kSecond_us}) {
    CheckSigmas(ComputeGuessCovariance(Guess(utime), Driven(0.8)), 50.0, kPi / std::sqrt(3.0));
  }
  CHECK(ComputeGuessCovariance(Guess(-1), Driven(0.8))[0] < kUnknownVariance);
  CheckSigmas(ComputeGuessCovariance(Guess(9 * kSecond_us - 1), Driven(0.8)), 0.35, 0.1);  // clocks step back
}

TEST_CASE("a guess that follows the wheels is worth as much less as they err, however long that takes") {
  TrackingState tracking;
  ScanMatch match = Guess(0, {1.0, 2.0, 0.5}, MatchState::kOk);
  tracking.Add(match);
  ScanMatch guess = Guess(100 * kSecond_us);
  guess.by_wheels = WheelMotion{{3.0, -4.0, 0.5}, 0.5, 0.05};
  guess.T_map_laser = match.T_map_laser * guess.by_wheels->T_from_to;
  CheckSigmas(ComputeGuessCovariance(guess, tracking), 0.35 + 0.5, 0.1 + 0.05);
  guess.by_wheels.reset();  // they are not believed
  CheckSigmas(ComputeGuessCovariance(guess, tracking), 0.35 + 17.5, kPi / std::sqrt(3.0));
}

TEST_CASE("of another drive nothing is known, unless somebody has told its place") {
  TrackingState tracking = Driven(0.8);
  tracking.BeginSession(Onset::kAnywhere);
  CHECK(ComputeGuessCovariance(Guess(10 * kSecond_us, tracking.T_map_guess()), tracking)[0] == kUnknownVariance);
  CHECK(ComputeGuessCovariance(Guess(10 * kSecond_us, tracking.T_map_guess()), tracking)[5] == kUnknownVariance);
  tracking.BeginSessionNear({3.0, 4.0, 0.5});
  CheckSigmas(ComputeGuessCovariance(Guess(10'000 * kSecond_us, {3.0, 4.0, 0.5}), tracking), 0.35, 0.1);
  CHECK(ComputeGuessCovariance(Guess(10 * kSecond_us), tracking)[0] == kUnknownVariance);
}

TEST_CASE("on a finished map nothing is known before the first match") {
  TrackingState tracking = TrackingState::OnFinishedMap();
  CHECK(ComputeGuessCovariance(Guess(0), tracking)[0] == kUnknownVariance);
  Lose(tracking, 3, kSecond_us);
  CHECK(tracking.recent().back().covariance[0] == kUnknownVariance);
  tracking.Add(Guess(5 * kSecond_us, {}, MatchState::kOk));
  Lose(tracking, 1, kSecond_us);
  CheckSigmas(tracking.recent().back().covariance, 0.525, 0.15);
}

}  // namespace crsm
