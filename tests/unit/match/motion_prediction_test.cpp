#include "common/match/motion_prediction.hpp"

#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// Matches of a drive of `motion` a scan.
std::vector<ScanMatch> Drive(int num_scans, const Pose2& motion) {
  Pose2 pose;
  std::vector<ScanMatch> history;
  for (int k = 0; k < num_scans; ++k) {
    history.push_back(MatchedAt(k, pose));
    pose = pose * motion;
  }
  return history;
}

}  // namespace

TEST_CASE("the initial guess is the first pose, or the last motion repeated") {
  const std::vector<ScanMatch> history{MatchedAt(100, {1.0, 0.0, 0.0}), MatchedAt(200, {1.1, 0.0, 0.1})};
  CHECK(PredictPose({history.data(), 1}) == history.front().T_map_laser);
  // 0.1 m ahead and 0.1 rad to the left, seen from the last pose, which looks 0.1 rad to the left already.
  CheckPose(PredictPose(history), {1.1 + 0.1 * std::cos(0.1), 0.1 * std::sin(0.1), 0.2}, 1e-9);
}

TEST_CASE("the guessed way is the mean of the last four, and no motion through a lost scan counts") {
  std::vector<ScanMatch> history;
  for (const double x_m : {0.0, 9.0, 9.1, 9.3, 9.4, 9.6}) history.push_back(MatchedAt(1, {x_m, 0.0, 0.0}));
  CheckPose(PredictPose(history), {9.6 + (0.1 + 0.2 + 0.1 + 0.2) / 4, 0.0, 0.0}, 1e-9);
  history[4].state = MatchState::kLost;
  CheckPose(PredictPose(history), history.back().T_map_laser, 1e-9);
}

TEST_CASE("where nothing seen holds the position, the guessed way is the mean of the nine motions of ten matches") {
  std::vector<ScanMatch> history;
  for (int k = 0; k < 11; ++k) history.push_back(MatchedAt(k, {0.1 * k * k, 0.0, 0.0}));
  history.back().state = MatchState::kDegenerate;
  CheckPose(PredictPose(history), {10.0 + (10.0 - 0.1) / 9, 0.0, 0.0}, 1e-9);
}

TEST_CASE("... but none that began more than two seconds ago, beyond the last four") {
  const auto GuessedAtStepOf = [&](std::int64_t step_us) {
    std::vector<ScanMatch> history;
    for (int k = 0; k < 11; ++k) history.push_back(MatchedAt(k * step_us, {0.1 * k * k, 0.0, 0.0}));
    history.back().state = MatchState::kDegenerate;
    return PredictPose(history);
  };
  CheckPose(GuessedAtStepOf(400'000), {10.0 + (10.0 - 2.5) / 5, 0.0, 0.0}, 1e-9);
  CheckPose(GuessedAtStepOf(1'000'000), {10.0 + (10.0 - 3.6) / 4, 0.0, 0.0}, 1e-9);
}

TEST_CASE("a motion is the less steady the longer ago the last match") {
  const std::vector<ScanMatch> history{MatchedAt(5'000'000, {})};
  CHECK(ComputeSteadiness({}, 5'000'000) == 1.0);
  CHECK(ComputeSteadiness(history, 5'000'000) == 1.0);
  CHECK(ComputeSteadiness(history, 5'300'000) == 1.0);
  CHECK(ComputeSteadiness(history, 5'600'000) == Approx(0.25));
  CHECK(ComputeSteadiness(history, 8'000'000) == Approx(0.01));
}

TEST_CASE("the guessed turn is the last one alone: a robot turns soon in another way") {
  std::vector<ScanMatch> history;
  for (const double yaw_rad : {0.0, 0.1, 0.3, 0.6, 0.65}) history.push_back(MatchedAt(1, {1.0, 2.0, yaw_rad}));
  CheckPose(PredictPose(history), {1.0, 2.0, 0.70}, 1e-9);
}

TEST_CASE("a robot that drives round a circle is guessed on the circle") {
  const Pose2 step{0.1, 0.02, 0.3};
  const auto history = Drive(9, step);
  CheckPose(PredictPose({history.data(), 8}), history.back().T_map_laser, 1e-9);
}

}  // namespace crsm
