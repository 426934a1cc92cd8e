#include <algorithm>
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

template <class Paint>
RrhcMatcher MatcherOn(Paint&& paint, const MatchParameters& parameters = {}) {
  RrhcMatcher matcher(parameters, 0.05);
  matcher.Apply(PaintTiles(-1, 1, paint));
  return matcher;
}

RrhcMatcher MatcherInNiche(const MatchParameters& parameters = {}) { return MatcherOn(NicheByte, parameters); }

/// A scan of nothing that is on any map: a wall all round.
LaserScan ScanOfElsewhere(std::int64_t utime) {
  return ScanAllRound([](double, double, double) { return 1.3; }, {}, utime, 360);
}

/// On the map of two walls along x, between which no place along them is like another only by what is guessed.
ScanMatch MatchBetweenWalls(const Pose2& told_motion, MatchState last_state) {
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
  return matcher.Match(ShippedRays(ScanWalls(walls, {}, 100)), After(matches), kOdometryStart * told_motion);
}

/// The niche, and in it a ring of walls about 1 m around a place: what is seen of the niche from there lies behind it.
const Pose2 kRinged{-0.5, 0.3, 0.2};
std::uint8_t RingedByte(Cell cell) {
  return std::max(std::abs(cell.x + 10), std::abs(cell.y - 6)) == 20 ? kOccupiedByte : NicheByte(cell);
}

}  // namespace

TEST_CASE("as shipped, a scan whose rays run through walls is lost on a finished map, however well they end") {
  for (const bool is_ringed : {false, true}) {
    for (const bool grows : {false, true}) {  // whose walls may have been there for a moment
      const TrackingState before = grows ? AfterStanding(kRinged, kUsual) : After({MatchedAt(1, kRinged)});
      const RrhcMatcher matcher = is_ringed ? MatcherOn(RingedByte) : MatcherOn(NicheByte);
      const ScanMatch match = matcher.Match(ShippedRays(ScanNiche(kRinged, 100)), before, {});
      CHECK(match.fitness > 0.8);
      CHECK(match.state == (is_ringed && !grows ? MatchState::kLost : MatchState::kOk));
      if (match.state == MatchState::kLost) CHECK(match.T_map_laser == kRinged);  // where it was last
    }
  }
}

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
  CHECK(match.T_odom_robot == kOdometryStart * truth);
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
  const RrhcMatcher matcher = MatcherInNiche();
  for (const Pose2& motion : {Pose2{0.07, 0.01, 0.3}, {}}) {
    std::optional<Pose2> T_odom_robot;
    if (motion != Pose2{}) T_odom_robot = *drive.back().T_odom_robot * motion;
    const ScanMatch match = matcher.Match(ShippedRays(ScanOfElsewhere(100)), After(drive), T_odom_robot);
    CHECK(match.state == MatchState::kLost);
    CheckPose(match.T_map_laser, drive.back().T_map_laser * motion, 1e-9);
  }
}

TEST_CASE("as shipped, a match far from where reliable wheels say is believed where it fits nearly as scans do") {
  const auto StateAfter = [&](double usual_fitness, bool has_odometry) {
    TrackingState tracking;
    for (int k = 0; k < 30; ++k) {  // to and fro, as the wheels say
      const Pose2 pose{k % 2 == 0 ? -1.0 : -0.2, 0.5, 0.4};
      ScanMatch match = MatchedAt(k * 1'000'000, pose);
      match.fitness = usual_fitness;
      match.T_odom_robot = pose;
      tracking.Add(match);
    }
    REQUIRE(tracking.wheels().IsReliable());
    const Pose2& last = tracking.recent().back().T_map_laser;  // where they say that the robot still is
    const auto odometry = has_odometry ? std::optional(last) : std::nullopt;
    const LaserScan scan = ScanNiche({last.x_m - 0.6, last.y_m, last.yaw_rad}, 30 * 1'000'000);
    return MatcherInNiche().Match(ShippedRays(scan), tracking, odometry).state;
  };
  CHECK(StateAfter(0.8, true) != MatchState::kLost);
  CHECK(StateAfter(1.2, true) == MatchState::kLost);  // it fits with 0.88
  CHECK(StateAfter(1.2, false) != MatchState::kLost);
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

TEST_CASE("as shipped, a robot lost on a finished map is looked for everywhere after ten losses, and after ten more") {
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
  CHECK(looked_everywhere == std::vector<int>{67, 77, 87});
}

}  // namespace crsm
