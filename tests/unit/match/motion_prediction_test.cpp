#include "common/match/motion_prediction.hpp"

#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// A drive of 0.1 m and 0.05 rad a scan as the odometry tells it, in a frame of its own.
const Pose2 kStep{0.1, 0.0, 0.05};
const Pose2 kOdometryStart{100.0, -50.0, 2.0};

/// Matches of a drive of `motion` a scan, with odometry that tells of `told` a scan.
std::vector<ScanMatch> Drive(int num_scans, const Pose2& motion, const Pose2& told) {
  Pose2 pose;
  Pose2 odometry = kOdometryStart;
  std::vector<ScanMatch> history;
  for (int k = 0; k < num_scans; ++k) {
    history.push_back({k, pose, 1.0, 1, 1, k, MatchState::kOk, 1, {}, {}, odometry});
    pose = pose * motion;
    odometry = odometry * told;
  }
  return history;
}

}  // namespace

TEST_CASE("the presumed pose is the last one, or the last motion repeated") {
  MatchParameters parameters = TestParameters().match;
  const std::vector<ScanMatch> history{MatchedAt(100, {1.0, 0.0, 0.0}), MatchedAt(200, {1.1, 0.0, 0.1})};
  parameters.velocity_model = false;
  CHECK(PredictPose(history, parameters) == history.back().T_map_laser);
  parameters.velocity_model = true;
  CHECK(PredictPose({history.data(), 1}, parameters) == history.front().T_map_laser);
  // 0.1 m ahead and 0.1 rad to the left, seen from the last pose, which looks 0.1 rad to the left already.
  CheckPose(PredictPose(history, parameters), {1.1 + 0.1 * std::cos(0.1), 0.1 * std::sin(0.1), 0.2}, 1e-9);
}

TEST_CASE("the presumed way is the mean of the last four, and no motion through a lost scan counts") {
  const MatchParameters parameters = TestParameters().match;
  std::vector<ScanMatch> history;
  for (const double x_m : {0.0, 9.0, 9.1, 9.3, 9.4, 9.6}) history.push_back(MatchedAt(1, {x_m, 0.0, 0.0}));
  CheckPose(PredictPose(history, parameters), {9.6 + (0.1 + 0.2 + 0.1 + 0.2) / 4, 0.0, 0.0}, 1e-9);
  history[4].state = MatchState::kLost;
  CheckPose(PredictPose(history, parameters), history.back().T_map_laser, 1e-9);
}

TEST_CASE("where nothing seen holds the position, the presumed way is the mean of the nine motions of ten matches") {
  const MatchParameters parameters = TestParameters().match;
  std::vector<ScanMatch> history;
  for (int k = 0; k < 11; ++k) history.push_back(MatchedAt(k, {0.1 * k * k, 0.0, 0.0}));
  history.back().state = MatchState::kDegenerate;
  CheckPose(PredictPose(history, parameters), {10.0 + (10.0 - 0.1) / 9, 0.0, 0.0}, 1e-9);
}

TEST_CASE("... but none that began more than two seconds ago, beyond the last four") {
  const MatchParameters parameters = TestParameters().match;
  const auto PresumedAtStepOf = [&](std::int64_t step_us) {
    std::vector<ScanMatch> history;
    for (int k = 0; k < 11; ++k) history.push_back(MatchedAt(k * step_us, {0.1 * k * k, 0.0, 0.0}));
    history.back().state = MatchState::kDegenerate;
    return PredictPose(history, parameters);
  };
  CheckPose(PresumedAtStepOf(400'000), {10.0 + (10.0 - 2.5) / 5, 0.0, 0.0}, 1e-9);
  CheckPose(PresumedAtStepOf(1'000'000), {10.0 + (10.0 - 3.6) / 4, 0.0, 0.0}, 1e-9);
}

TEST_CASE("a motion is the less steady the longer ago the last match") {
  const std::vector<ScanMatch> history{MatchedAt(5'000'000, {})};
  CHECK(ComputeSteadiness({}, 5'000'000) == 1.0);
  CHECK(ComputeSteadiness(history, 5'000'000) == 1.0);
  CHECK(ComputeSteadiness(history, 5'300'000) == 1.0);
  CHECK(ComputeSteadiness(history, 5'600'000) == Approx(0.25));
  CHECK(ComputeSteadiness(history, 8'000'000) == Approx(0.01));
}

TEST_CASE("the presumed turn is the last one alone: a robot turns soon in another way") {
  const MatchParameters parameters = TestParameters().match;
  std::vector<ScanMatch> history;
  for (const double yaw_rad : {0.0, 0.1, 0.3, 0.6, 0.65}) history.push_back(MatchedAt(1, {1.0, 2.0, yaw_rad}));
  CheckPose(PredictPose(history, parameters), {1.0, 2.0, 0.70}, 1e-9);
}

TEST_CASE("a robot that drives round a circle is presumed on the circle") {
  const MatchParameters parameters = TestParameters().match;
  const Pose2 step{0.1, 0.02, 0.3};
  const auto history = Drive(9, step, step);
  CheckPose(PredictPose({history.data(), 8}, parameters), history.back().T_map_laser, 1e-9);
}

/// When the next scan is taken.
static std::int64_t NextTime(const std::vector<ScanMatch>& history) { return history.back().utime + 100'000; }

TEST_CASE("by odometry the presumed pose is the last one and the motion of the wheels since") {
  const MatchParameters parameters = TestParameters().match;
  const auto history = Drive(8, kStep, kStep);
  // The robot stops, turns on the spot, or goes on: what no repeated motion tells.
  for (const Pose2& motion : {Pose2{}, {0.0, 0.0, -0.4}, {0.3, 0.0, 0.1}}) {
    const auto presumed =
        PredictPoseByOdometry(history, NextTime(history), *history.back().T_odom_robot * motion, parameters);
    REQUIRE(presumed);
    CheckPose(*presumed, history.back().T_map_laser * motion, 1e-9);
  }
}

TEST_CASE("odometry that is missing, jumps or tells the last motions wrong presumes nothing") {
  const MatchParameters parameters = TestParameters().match;
  auto history = Drive(8, kStep, kStep);
  const Pose2 last = *history.back().T_odom_robot;
  CHECK_FALSE(PredictPoseByOdometry(history, NextTime(history), std::nullopt, parameters));
  CHECK_FALSE(PredictPoseByOdometry(history, NextTime(history), last * Pose2{5.0, 0.0, 0.0}, parameters));
  CHECK_FALSE(PredictPoseByOdometry(history, NextTime(history), last * Pose2{0.0, 0.0, 3.0}, parameters));
  CHECK_FALSE(PredictPoseByOdometry(history, NextTime(history), Pose2{}, parameters));  // it was reset
  history.back().T_odom_robot.reset();
  CHECK_FALSE(PredictPoseByOdometry(history, NextTime(history), last, parameters));

  const Pose2 reverse{-0.1, 0.0, 0.05};
  const auto wrong = Drive(8, kStep, reverse);
  CHECK_FALSE(PredictPoseByOdometry(wrong, NextTime(wrong), *wrong.back().T_odom_robot * reverse, parameters));
}

TEST_CASE("the longer the time between two scans, the further the wheels may have gone") {
  const MatchParameters parameters = TestParameters().match;
  const auto history = Drive(8, kStep, kStep);
  const Pose2 there = *history.back().T_odom_robot * Pose2{2.5, 0.0, 2.0};
  const std::int64_t last = history.back().utime;
  CHECK_FALSE(PredictPoseByOdometry(history, last + 500'000, there, parameters));
  const auto presumed = PredictPoseByOdometry(history, last + 1'000'000, there, parameters);
  REQUIRE(presumed);
  CheckPose(*presumed, history.back().T_map_laser * Pose2{2.5, 0.0, 2.0}, 1e-9);
}

TEST_CASE("odometry that was wrong is believed again after some scans that it told right") {
  const MatchParameters parameters = TestParameters().match;
  auto history = Drive(30, kStep, kStep);
  for (int k = 0; k < 20; ++k) {  // it jumped at the 20th
    ScanMatch& match = history[static_cast<std::size_t>(k)];
    match.T_odom_robot = Pose2{3.0, 3.0, 1.0} * *match.T_odom_robot;
  }
  const auto Presume = [&](std::size_t num_scans) {
    return PredictPoseByOdometry({history.data(), num_scans}, history[num_scans].utime, history[num_scans].T_odom_robot,
                                 parameters);
  };
  CHECK(Presume(19));
  CHECK_FALSE(Presume(20));  // the jump itself
  CHECK_FALSE(Presume(21));
  CHECK(Presume(27));
}

}  // namespace crsm
