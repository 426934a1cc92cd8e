#include "common/rrhc_matcher.hpp"

#include <cmath>

#include "catch.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

const MapGeometry kGeometry(0.05);
const std::vector<ScanMatch> kAtOrigin{{1, {}, 0.0, 0, 0, 0, MatchState::kFirst}};

// As many evaluations as make every seed find the pose: these tests are of the search, not of its luck.
MatchParameters Shrinking() {
  MatchParameters parameters = TestParameters().match;
  parameters.num_evaluations = 10000;
  return parameters;
}

MatchParameters PaperLike() {
  MatchParameters parameters = TestParameters().match;
  parameters.num_evaluations = 50000;
  parameters.unexplored_score = -100.0;
  parameters.climb = ClimbMode::kFixed;
  parameters.interpolate = false;
  parameters.velocity_model = false;
  parameters.final_climb = false;
  return parameters;
}

/// Matches a scan of the room, taken at a pose, to a perfect map of the room.
ScanMatch MatchInRoom(const Pose2& truth, const MatchParameters& parameters,
                      const std::vector<ScanMatch>& history = kAtOrigin, std::int64_t utime = 2) {
  RrhcMatcher matcher(parameters);
  REQUIRE(matcher.ApplyChanges(PaintTiles(-1, 1, RoomByte)));
  const ValidRays rays = FindValidRays(ScanRoom(truth, utime), TestParameters().scan);
  const RaySelection selection = SelectRays(rays, TestParameters().selection);
  return matcher.Match(utime, rays, selection.critical, history, kGeometry, 7);
}

void CheckPose(const Pose2& pose, const Pose2& truth, double margin_m) {
  CHECK(pose.x_m == Approx(truth.x_m).margin(margin_m));
  CHECK(pose.y_m == Approx(truth.y_m).margin(margin_m));
  CHECK(pose.yaw_rad == Approx(truth.yaw_rad).margin(margin_m / 3.0));  // at the walls, 3 m away, it is as much
}

ScanMatch MatchedAt(std::int64_t utime, const Pose2& pose) { return {utime, pose, 1.0, 1, 1, 0, MatchState::kOk}; }

}  // namespace

TEST_CASE("a scan shifted 0.10 m in x is matched back within half a cell") {
  const ScanMatch match = MatchInRoom({0.10, 0.0, 0.0}, Shrinking());
  CHECK(match.state == MatchState::kOk);
  CheckPose(match.T_map_laser, {0.10, 0.0, 0.0}, 0.025);
}

TEST_CASE("a scan shifted and turned within the window is matched back, by the paper's coarser steps within a cell") {
  for (const Pose2& truth : {Pose2{}, {-0.3, 0.25, 0.15}, {0.2, -0.35, -0.2}, {0.0, 0.0, 0.24}}) {
    CAPTURE(truth.x_m, truth.y_m, truth.yaw_rad);
    CheckPose(MatchInRoom(truth, Shrinking()).T_map_laser, truth, 0.025);
    CheckPose(MatchInRoom(truth, PaperLike()).T_map_laser, truth, 0.05);
  }
}

TEST_CASE("a final climb over all rays comes to a fifth of a cell") {
  CheckPose(MatchInRoom({0.12, 0.07, 0.05}, Shrinking()).T_map_laser, {0.12, 0.07, 0.05}, 0.01);
}

TEST_CASE("the first scan is the origin of the map") {
  const ScanMatch match = MatchInRoom({0.1, 0.2, 0.3}, Shrinking(), {});
  CHECK(match.state == MatchState::kFirst);
  CHECK(match.T_map_laser == Pose2{});
  CHECK(match.utime == 2);
  CHECK(match.num_critical > 0);
}

TEST_CASE("a scan without rays is lost where it was presumed") {
  RrhcMatcher matcher(PaperLike());
  const std::vector<ScanMatch> history{MatchedAt(1, {1.0, 2.0, 0.5})};
  const ScanMatch match = matcher.Match(9, {}, {}, history, kGeometry, 3);
  CHECK(match.state == MatchState::kLost);
  CHECK(match.T_map_laser == Pose2{1.0, 2.0, 0.5});
  CHECK(match.utime == 9);
  CHECK(match.map_version == 3);
  CHECK(match.evaluations == 0);
}

TEST_CASE("a match says how it came about") {
  const ScanMatch match = MatchInRoom({0.05, 0.0, 0.0}, PaperLike());
  CHECK(match.utime == 2);
  CHECK(match.map_version == 7);
  CHECK(match.evaluations == 50000);
  CHECK(match.num_critical >= 60);
  CHECK(match.num_critical <= 90);
  CHECK(match.fitness > 0.85);  // a wall cell has two wall cells, a free and an unexplored one beside it: 3188 of 3570
  CHECK(match.fitness <= 1.0);
}

TEST_CASE("the search stops where the fitness satisfies") {
  MatchParameters parameters = PaperLike();
  parameters.satisfying_fitness = 0.3;
  CHECK(MatchInRoom({}, parameters).evaluations < 100);
}

TEST_CASE("the same seed gives the same match, bit for bit, and another seed one within a cell") {
  for (MatchParameters parameters : {Shrinking(), PaperLike()}) {
    const ScanMatch match = MatchInRoom({0.1, -0.1, 0.1}, parameters);
    CHECK(MatchInRoom({0.1, -0.1, 0.1}, parameters) == match);
    parameters.seed = 2;
    const ScanMatch other = MatchInRoom({0.1, -0.1, 0.1}, parameters);
    CHECK_FALSE(other == match);
    CheckPose(other.T_map_laser, match.T_map_laser, 0.05);
  }
}

TEST_CASE("a match on an empty map is a pose within the window, with fitness 0") {
  RrhcMatcher matcher(PaperLike());
  const ValidRays rays = FindValidRays(ScanRoom({}), TestParameters().scan);
  const std::vector<int> critical{0, 10, 20};
  const ScanMatch match = matcher.Match(2, rays, critical, kAtOrigin, kGeometry, 0);
  CHECK(match.fitness == 0.0);
  CHECK(std::abs(match.T_map_laser.x_m) <= 0.5);  // window and one mutation
  CHECK(std::abs(match.T_map_laser.y_m) <= 0.5);
}

TEST_CASE("a malformed change is reported, and the others are applied") {
  RrhcMatcher matcher(PaperLike());
  const std::vector<TileChange> changes{{{0, 0}, {0, 0, 0, 1, 9}}, {{1, 0}, {0, 0, 0}}, {{2, 0}, {0, 0, 0, 1, 8}}};
  CHECK_FALSE(matcher.ApplyChanges(changes));
  CHECK(matcher.map().At({0, 0}) == 9);
  CHECK(matcher.map().At({64, 0}) == kUnexploredByte);
  CHECK(matcher.map().At({128, 0}) == 8);
}

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

}  // namespace crsm
