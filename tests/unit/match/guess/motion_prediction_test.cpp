#include "common/match/guess/motion_prediction.hpp"

#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "synthetic_scans.hpp"

namespace crsm {

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

TEST_CASE("where nothing seen holds the position, the guessed way is the mean of nine motions within two seconds") {
  const std::pair<std::int64_t, double> cases[] = {
      {1, (10.0 - 0.1) / 9}, {400'000, (10.0 - 2.5) / 5}, {1'000'000, (10.0 - 3.6) / 4}};  // four in any case
  for (const auto& [step_us, way_m] : cases) {
    std::vector<ScanMatch> history;
    for (int k = 1; k < 11; ++k) history.push_back(MatchedAt(k * step_us, {0.1 * k * k, 0.0, 0.0}));
    history.back().state = MatchState::kDegenerate;
    CheckPose(PredictPose(history), {10.0 + way_m, 0.0, 0.0}, 1e-9);
  }
}

TEST_CASE("the guessed turn is the last one alone, and a robot that drives round a circle is guessed on the circle") {
  std::vector<ScanMatch> turning;
  for (const double yaw_rad : {0.0, 0.1, 0.3, 0.6, 0.65}) turning.push_back(MatchedAt(1, {1.0, 2.0, yaw_rad}));
  CheckPose(PredictPose(turning), {1.0, 2.0, 0.70}, 1e-9);  // a robot turns soon in another way
  std::vector<ScanMatch> circle{MatchedAt(0, {})};
  for (int k = 1; k < 9; ++k) circle.push_back(MatchedAt(k, circle.back().T_map_laser * Pose2{0.1, 0.02, 0.3}));
  CheckPose(PredictPose({circle.data(), 8}), circle.back().T_map_laser, 1e-9);
}

TEST_CASE("a motion is the less steady the longer ago the last match") {
  const std::vector<ScanMatch> history{MatchedAt(5'000'000, {})};
  CHECK(ComputeSteadiness({}, 5'000'000) == 1.0);
  const std::pair<std::int64_t, double> cases[] = {
      {5'000'000, 1.0}, {5'300'000, 1.0}, {5'600'000, 0.25}, {8'000'000, 0.01}};
  for (const auto& [utime, steadiness] : cases) CHECK(ComputeSteadiness(history, utime) == Approx(steadiness));
}

}  // namespace crsm
