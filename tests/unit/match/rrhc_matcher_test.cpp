#include "common/match/rrhc_matcher.hpp"

#include <cmath>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/map/map_updater.hpp"
#include "common/worlds/world.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

const std::vector<ScanMatch> kAtOrigin{{1, {}, 0.0, 0, 0, 0, MatchState::kFirst}};

/// A matcher on a map of cells of 0.05 m.
template <class Paint>
RrhcMatcher MatcherOn(Paint&& paint, const MatchParameters& parameters = {}, const MatchConstants& constants = {}) {
  RrhcMatcher matcher(parameters, 0.05, constants);
  REQUIRE(matcher.Apply(PaintTiles(-1, 1, paint)));
  return matcher;
}

ScanMatch MatchScan(const RrhcMatcher& matcher, const LaserScan& scan, const std::vector<ScanMatch>& history) {
  return matcher.Match(RaysOf(scan), After(history), {});
}

/// Matches a scan of the room with the block, taken at a pose, to a perfect map of it.
ScanMatch MatchInNiche(const LaserScan& scan, const std::vector<ScanMatch>& history = {},
                       const MatchParameters& parameters = {}) {
  return MatchScan(MatcherOn(NicheByte, parameters), scan, history);
}

std::vector<ScanMatch> LostScans(int num) {
  std::vector<ScanMatch> history;
  for (int k = 0; k < num; ++k) history.push_back({k, {}, 0.0, 0, 0, k, MatchState::kLost});
  return history;
}

/// Matches a scan of the room, taken at a pose, to a perfect map of the room.
ScanMatch MatchInRoom(const Pose2& truth, const MatchParameters& parameters = {},
                      const std::vector<ScanMatch>& history = kAtOrigin) {
  return MatchScan(MatcherOn(RoomByte, parameters), ScanRoom(truth, 2), history);
}

/// A corridor with pillars on its walls; the laser does not see as far as its ends.
const World kCorridor = ParseWorld(
    "box -20 -1 40 2\nbox -2.9 0.85 0.15 0.15\nbox -1.6 0.85 0.15 0.15\nbox -0.8 -1 0.15 0.15\nbox 1.7 0.85 0.15 0.15\n"
    "box 2.1 -1 0.15 0.15\nbox 3.1 -1 0.15 0.15\n"
    "laser 360 360 8 5 0\nspeed 1 1\nwaypoint 0 0\nwaypoint 1 0\n",
    "corridor with pillars");

LaserScan ScanCorridor(double x_m, std::int64_t utime) {
  const auto Range = [](double from_x_m, double from_y_m, double angle_rad) {
    const double range_m = CastRay(kCorridor.walls, {from_x_m, from_y_m}, ComputeSinCos(angle_rad));
    return range_m < kCorridor.laser.range_max_m ? range_m : 0.0;
  };
  return ScanAllRound(Range, {x_m, 0.0, 0.0}, utime, 360);
}

/// Matches a scan of the corridor, taken so far from where it is guessed, to a map of it.
ScanMatch MatchInCorridor(double way_m, const MatchConstants& constants = {}) {
  RrhcMatcher matcher({}, 0.05, constants);
  MapUpdater updater(UpdateParameters{});
  std::vector<ScanMatch> history;
  for (int k = 0; k < 12; ++k) {
    const ScanMatch match = MatchedAt(k, {0.5 * k - 3.0, 0.0, 0.0});
    REQUIRE(matcher.Apply(updater.Update(AllRays(ScanCorridor(match.T_map_laser.x_m, k)), match).tiles));
  }
  for (int k = 12; k < 20; ++k) {  // it stands
    history.push_back({k, {}, 0.8, 1, 1, k, k == 12 ? MatchState::kFirst : MatchState::kDegenerate});
  }
  return MatchScan(matcher, ScanCorridor(way_m, 20), history);
}

}  // namespace

TEST_CASE("a scan shifted and turned within the window is matched back, mostly to a fifth of a cell, and says how") {
  for (const Pose2& truth : {Pose2{}, {0.1, 0.0, 0.0}, {-0.3, 0.25, 0.15}, {0.2, -0.35, -0.2}, {0.0, 0.0, 0.24}}) {
    CAPTURE(truth.x_m, truth.y_m, truth.yaw_rad);
    const ScanMatch match = MatchInRoom(truth);
    CheckPose(match.T_map_laser, truth, 0.025);
    CHECK(match.state == MatchState::kOk);
    CHECK(match.utime == 2);
    CHECK(match.evaluations > 100);
    CHECK(match.best_evaluation > 0);
    CHECK((match.num_critical >= 60 && match.num_critical <= 90));
    // A wall cell has two wall cells, a free and an unexplored one beside it: 3188 of 3570.
    CHECK((match.fitness > (truth.yaw_rad == 0.0 ? 0.85 : 0.7) && match.fitness <= 1.0));
  }
  CheckPose(MatchInRoom({0.12, 0.07, 0.05}).T_map_laser, {0.12, 0.07, 0.05}, 0.01);
}

TEST_CASE("a match in a room that is not along the cells ends within a tenth of a cell, as one along them does") {
  MatchConstants constants;  // the climb alone
  constants.prior.per_m2 = constants.final_climb.optimum_rad = constants.final_climb.spacing_max_m = 0.0;
  const auto ErrorAt = [&](double aside_m, double yaw_rad) {
    const Pose2 first{aside_m, -0.6 * aside_m, yaw_rad};
    RrhcMatcher matcher({}, 0.05, constants);
    MapUpdater updater(UpdateParameters{});
    REQUIRE(matcher.Apply(updater.Update(AllRays(ScanRoom({}, 1)), MatchedAt(1, first)).tiles));
    const Pose2 truth{0.12, 0.07, 0.0};
    const Pose2 found = MatchScan(matcher, ScanRoom(truth, 2), {MatchedAt(1, first)}).T_map_laser;
    return Distance(found, first * truth);
  };
  for (const double yaw_rad : {0.0, 0.3}) {
    double error_m = 0.0;
    for (int i = 0; i < 20; ++i) error_m += ErrorAt(0.005 * i, yaw_rad) / 20.0;
    CAPTURE(yaw_rad, error_m);
    CHECK(error_m < 0.005);
  }
}

TEST_CASE("in a corridor a pose that was guessed too far back is found by the few rays that tell") {
  for (const double way_m : {-0.35, 0.0, 0.2, 0.35}) {
    CAPTURE(way_m);
    const ScanMatch match = MatchInCorridor(way_m);
    CHECK(match.state == MatchState::kDegenerate);
    CheckPose(match.T_map_laser, {way_m, 0.0, 0.0}, 0.03);
  }
  MatchConstants constants;
  constants.final_climb.look_gain = 1.0;
  CHECK(std::abs(MatchInCorridor(0.35, constants).T_map_laser.x_m) < 0.2);
}

TEST_CASE("the first scan is the origin of the map, and a scan without rays is lost where it was guessed to be") {
  const ScanMatch first = RrhcMatcher({}, 0.05).Match(RaysOf(ScanRoom({0.1, 0.2, 0.3}, 2)), {}, {});
  CHECK(first.state == MatchState::kFirst);
  CHECK(first.T_map_laser == Pose2{});
  CHECK(first.utime == 2);
  CHECK(first.num_critical > 0);
  const ScanMatch lost = MatcherOn(RoomByte).Match({9, {}, {}}, After({MatchedAt(1, {1.0, 2.0, 0.5})}), {});
  CHECK(lost.state == MatchState::kLost);
  CHECK(lost.T_map_laser == Pose2{1.0, 2.0, 0.5});
  CHECK(lost.utime == 9);
  CHECK(lost.evaluations == 0);
}

TEST_CASE("on a finished map a room that is alike from both ends loses the first scan, unless its start is told") {
  const Pose2 truth{-2.2, 1.9, 2.5};
  const Pose2 turned{1.0 - truth.x_m, 1.0 - truth.y_m, WrapAngle(truth.yaw_rad + kPi)};  // about the room's centre
  CHECK(MatchInRoom(truth, {}, {}).state == MatchState::kLost);
  CheckPose(MatchInRoom(truth, {.start = Pose2{-2.0, 1.7, 2.3}}, {}).T_map_laser, truth, 0.025);
  CheckPose(MatchInRoom(truth, {.start = turned}, {}).T_map_laser, turned, 0.025);
}

TEST_CASE("a start that is wrong is not believed, and the next scan is looked for everywhere") {
  const Pose2 truth{-2.2, 1.9, 2.5};
  MatchParameters parameters;
  parameters.start = Pose2{-2.0, -1.2, 0.0};
  const ScanMatch first = MatchInNiche(ScanNiche(truth, 1), {}, parameters);
  CHECK(first.state == MatchState::kLost);
  const ScanMatch second = MatchInNiche(ScanNiche(truth, 2), {first}, parameters);
  CHECK(second.state == MatchState::kOk);
  CheckPose(second.T_map_laser, truth, 0.025);
}

TEST_CASE(
    "a scan that was found nowhere yet is looked for each time, then each tenth time, then more seldom, on a finished "
    "map alone") {
  const LaserScan elsewhere = ScanNiche({2.2, -1.0, 0.0});
  const auto Evaluations = [&](int num_lost) { return MatchInNiche(elsewhere, LostScans(num_lost)).evaluations; };
  for (const int num_lost : {0, 1, 9, 10, 20, 190, 330, 1500}) CHECK(Evaluations(num_lost) > 1000);
  // The longer it was found nowhere, the more seldom: every tenth of the hundredth part of the scans.
  for (const int num_lost : {11, 19, 310, 1501, 1510, 1590}) CHECK(Evaluations(num_lost) == 0);
  std::vector<ScanMatch> grows = LostScans(20);
  grows.front().state = MatchState::kFirst;
  CHECK(MatchInNiche(ScanNiche({-2.2, 1.9, 2.5}), grows).evaluations < 5000);
}

TEST_CASE("the same seed gives the same match, bit for bit, and another seed one within a cell") {
  const ScanMatch match = MatchInRoom({0.1, -0.1, 0.1});
  CHECK(MatchInRoom({0.1, -0.1, 0.1}) == match);
  const ScanMatch other = MatchInRoom({0.1, -0.1, 0.1}, {.seed = 2});
  CHECK_FALSE(other == match);
  CheckPose(other.T_map_laser, match.T_map_laser, 0.05);
}

TEST_CASE("where the map tells nothing, a match is the initial guess, with fitness 0") {
  const ScanMatch match = MatchScan(MatcherOn([](Cell) { return kFreeByte; }), ScanRoom({}, 2), kAtOrigin);
  CHECK(match.fitness == 0.0);
  CHECK(match.T_map_laser == Pose2{});  // no pose is better
}

}  // namespace crsm
