#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/match/rrhc_matcher.hpp"
#include "synthetic_scans.hpp"

// Where the matcher begins to search as it ships: with the parameters that nobody set.

namespace crsm {
namespace {

const Pose2 kOdometryStart{100.0, -50.0, 2.0};
constexpr double kUsual = 0.85;  // fitness of scans of the niche on its map: 0.88

RrhcMatcher MatcherInNiche(const MatchParameters& parameters = {}) {
  RrhcMatcher matcher(parameters, 0.05);
  matcher.Apply(PaintTiles(-1, 1, NicheByte));
  return matcher;
}

/// A scan of nothing that is on any map: a wall all round.
LaserScan ScanOfElsewhere(std::int64_t utime) {
  return ScanAllRound([](double, double, double) { return 1.3; }, {}, utime, 360);
}

/// On the map of two walls along x, between which no place along them is like another only by what is guessed.
ScanMatch MatchBetweenWalls(const std::optional<Pose2>& told_motion, MatchState last_state) {
  const std::vector<Wall> walls{{{-30.0, -1.0}, {30.0, -1.0}}, {{-30.0, 1.0}, {30.0, 1.0}}};
  RrhcMatcher matcher({}, 0.05);
  MapUpdater updater(UpdateParameters{});
  for (int k = 0; k < 10; ++k) {
    const ScanMatch match = MatchedAt(k, {0.4 * k - 2.0, 0.0, 0.0});
    matcher.Apply(updater.Update(ShippedRays(ScanWalls(walls, match.T_map_laser, k)), match).tiles);
  }
  std::vector<ScanMatch> matches;
  for (int k = 0; k < 12; ++k) {
    matches.push_back({k, {}, 0.8, 1, 1, 0, k == 0 ? MatchState::kFirst : last_state, 0, {}, {}, kOdometryStart});
  }
  std::optional<Pose2> T_odom_robot;
  if (told_motion) T_odom_robot = kOdometryStart * *told_motion;
  return matcher.Match(ShippedRays(ScanWalls(walls, {}, 100)), After(matches), T_odom_robot);
}

}  // namespace

TEST_CASE("as shipped, odometry that fits no better than the last motions is not followed, unless walls left it open") {
  const Pose2 told{0.3, 0.0, 0.0};
  CHECK(std::abs(MatchBetweenWalls(told, MatchState::kOk).T_map_laser.x_m) < 0.1);
  CHECK(MatchBetweenWalls(told, MatchState::kDegenerate).T_map_laser.x_m == Approx(0.3).margin(0.1));
}

TEST_CASE("as shipped, odometry that fits clearly better than the last motions spares the wide search") {
  const Pose2 truth{0.5, -0.4, 0.8};  // the robot stood, and turns
  const TrackingState standing = AfterStanding({}, kUsual, 0, kOdometryStart);
  const CriticalRays rays = ShippedRays(ScanNiche(truth, 100));
  const ScanMatch match = MatcherInNiche().Match(rays, standing, kOdometryStart * truth);
  CheckPose(match.T_map_laser, truth, 0.025);
  CHECK(match.evaluations < MatchConstants{}.search.num_evaluations);
  const ScanMatch without = MatcherInNiche().Match(rays, standing, {});
  CheckPose(without.T_map_laser, truth, 0.025);
  CHECK(without.evaluations > MatchConstants{}.search.num_evaluations);
}

TEST_CASE("as shipped, a lost robot is where the wheels say, or where it was last seen: its motion is not repeated") {
  std::vector<ScanMatch> drive;  // 0.1 m a scan
  for (int k = 0; k < 12; ++k) {
    const Pose2 pose{0.1 * k - 1.0, 0.0, 0.2};
    drive.push_back(
        {k, pose, kUsual, 1, 1, 0, k == 0 ? MatchState::kFirst : MatchState::kOk, 0, {}, {}, kOdometryStart * pose});
  }
  const Pose2 last = drive.back().T_map_laser;
  const Pose2 motion{0.07, 0.01, 0.3};
  const RrhcMatcher matcher = MatcherInNiche();
  const CriticalRays elsewhere = ShippedRays(ScanOfElsewhere(100));
  const ScanMatch told = matcher.Match(elsewhere, After(drive), *drive.back().T_odom_robot * motion);
  CHECK(told.state == MatchState::kLost);
  CheckPose(told.T_map_laser, last * motion, 1e-9);
  const ScanMatch untold = matcher.Match(elsewhere, After(drive), {});
  CHECK(untold.state == MatchState::kLost);
  CHECK(untold.T_map_laser == last);
}

TEST_CASE("as shipped, a start that is told is believed at little cost, and mended where it is somewhat wrong") {
  const Pose2 truth{-0.5, 0.8, 0.4};
  const auto MatchFrom = [&](const Pose2& start) {
    MatchParameters parameters;
    parameters.start = start;
    return MatcherInNiche(parameters).Match(ShippedRays(ScanNiche(truth, 100)), TrackingState::OnFinishedMap(), {});
  };
  const ScanMatch right = MatchFrom(truth);
  CHECK(right.state == MatchState::kOk);
  CHECK(right.evaluations < MatchConstants{}.search.num_evaluations / 2);
  const ScanMatch wrong = MatchFrom({truth.x_m + 0.5, truth.y_m - 0.4, truth.yaw_rad + 0.9});
  CHECK(wrong.state == MatchState::kOk);
  CheckPose(wrong.T_map_laser, truth, 0.025);  // half a cell
}

TEST_CASE("as shipped, a robot lost on a finished map is looked for everywhere at each tenth scan after ten losses") {
  // Of 57 scans on that map it was found at all; then it is carried away.
  TrackingState tracking = TrackingState::OnFinishedMap();
  for (int k = 0; k < 57; ++k) tracking.Add({k, {1.0, 1.0, 0.0}, kUsual, 1, 1, 0, MatchState::kOk});
  const RrhcMatcher matcher = MatcherInNiche();
  std::vector<int> looked_everywhere;
  for (int k = 57; k < 92; ++k) {
    const ScanMatch match = matcher.Match(ShippedRays(ScanOfElsewhere(k)), tracking, {});
    CHECK(match.state == MatchState::kLost);
    if (match.evaluations > 100'000) looked_everywhere.push_back(k);  // 120 directions at each free place alone
    tracking.Add(match);
  }
  CHECK(looked_everywhere == std::vector<int>{70, 80, 90});
}

}  // namespace crsm
