#include "common/match/match_scan.hpp"

#include <algorithm>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/match/guess/guess_covariance.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kPeriod_us = 100'000;
const Pose2 kPlace{1.0, 2.0, 0.5};

/// Says what it was told to.
class ToldMatcher : public Matcher {
 public:
  explicit ToldMatcher(const ScanMatch& answer) : answer_(answer) {}
  ToldMatcher(const ScanMatch& answer, const ByteMap& map) : answer_(answer), map_(&map) {}
  bool Apply(std::span<const TileChange>) override { return true; }
  ScanMatch Match(const CriticalRays& scan, const TrackingState&,
                  const std::optional<Pose2>& T_odom_robot) const override {
    ScanMatch match = answer_;
    match.utime = scan.utime;
    match.T_odom_robot = T_odom_robot;
    return match;
  }
  const ByteMap& map() const override { return *map_; }
  std::optional<Pose2> Locate(const CriticalRays&) const override { return located_; }
  void SetLocated(const Pose2& pose) { located_ = pose; }

 private:
  ScanMatch answer_;
  std::optional<Pose2> located_;
  const ByteMap unexplored_{0.05};
  const ByteMap* map_ = &unexplored_;
};

ScanMatch Answer(MatchState state, const Pose2& pose = kPlace, double fitness = 0.8) {
  ScanMatch match;
  match.state = state;
  match.T_map_laser = pose;
  match.fitness = fitness;
  match.covariance = {1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-5};
  return match;
}

/// After ten scans that were matched at kPlace with a fitness of 0.8, and some that were lost.
TrackingState After(int num_lost, const std::optional<Pose2>& T_odom_robot = std::nullopt) {
  TrackingState tracking;
  for (int i = 0; i < 10 + num_lost; ++i) {
    ScanMatch match = Answer(i < 10 ? MatchState::kOk : MatchState::kLost);
    match.utime = i * kPeriod_us;
    match.T_odom_robot = T_odom_robot;
    if (i == 0 && T_odom_robot) match.T_odom_robot->x_m -= 0.1;  // wheels that never move are none
    tracking.Add(match);
  }
  return tracking;
}

void Add(TrackingState& tracking, MatchState state, const Pose2& pose, std::int64_t utime) {
  ScanMatch match = Answer(state, pose);
  match.utime = utime;
  tracking.Add(match);
}

CriticalRays ScanAfter(const TrackingState& tracking, std::int64_t later_us = kPeriod_us, int num_beams = 90) {
  return AllRays(ScanRoom({}, tracking.recent().back().utime + later_us, num_beams));
}

ScanMatch MatchAfter(const TrackingState& tracking, const ScanMatch& answer, const MatchOptions& options = {},
                     std::int64_t later_us = kPeriod_us, const std::optional<Pose2>& T_odom_robot = std::nullopt) {
  return MatchScan(ToldMatcher(answer), ScanAfter(tracking, later_us), tracking, T_odom_robot, options);
}

}  // namespace

TEST_CASE("the third lost scan in a row begins a trajectory where the robot is guessed to be") {
  const ScanMatch lost = Answer(MatchState::kLost, {1.5, 2.0, 0.5});
  for (int num_lost = 0; num_lost < 2; ++num_lost) CHECK(MatchAfter(After(num_lost), lost).state == MatchState::kLost);
  const TrackingState tracking = After(2);
  const ScanMatch first = MatchAfter(tracking, lost);
  CHECK(first.state == MatchState::kFirst);
  CheckPose(first.T_map_laser, kPlace, 1e-9);
  CHECK(first.utime == tracking.recent().back().utime + kPeriod_us);
  CHECK(first.covariance == ComputeGuessCovariance(first, tracking));
  CHECK(first.covariance[0] > 0.0);
}

TEST_CASE("a trajectory begins where the last scan was guessed to be, or where the wheels say") {
  const ScanMatch lost = Answer(MatchState::kLost, {0.9, 0.5, 0.0});
  const TrackingState tracking = After(2);
  CheckPose(MatchAfter(tracking, lost).T_map_laser, tracking.recent().back().T_map_laser, 1e-9);
  CheckPose(MatchAfter(After(2, Pose2{}), lost, {}, kPeriod_us, Pose2{}).T_map_laser, lost.T_map_laser, 1e-9);
}

TEST_CASE(
    "where the wheels lead on they bridge the break; a robot whose wheels stand for longer than a moment is carried, "
    "and "
    "nothing is bridged") {
  const auto Lost = [](const Pose2& T_odom_robot, std::int64_t later_us = kPeriod_us) {
    TrackingState tracking = After(0, Pose2{});
    for (int i = 0; i < 2; ++i) {
      ScanMatch match = MatchAfter(tracking, Answer(MatchState::kLost), {}, kPeriod_us, T_odom_robot);
      CHECK(match.by_wheels);
      tracking.Add(match);
    }
    return MatchAfter(tracking, Answer(MatchState::kLost, {1.5, 2.0, 0.5}), {}, later_us, T_odom_robot);
  };
  const ScanMatch bridged = Lost({0.4, 0.0, 0.0});
  CHECK(bridged.state == MatchState::kFirst);
  CHECK(bridged.by_wheels);
  CHECK(bridged.T_map_laser == Pose2{1.5, 2.0, 0.5});
  CHECK(bridged.covariance[0] > 0.0);
  CHECK(Lost({}).by_wheels);  // a hand before the laser
  const ScanMatch carried = Lost({}, 2'500'000);
  CHECK(carried.state == MatchState::kFirst);
  CHECK_FALSE(carried.by_wheels);
}

TEST_CASE("a match says how the wheels moved since the last scan, also where it is lost") {
  const TrackingState tracking = After(0, Pose2{});
  for (const MatchState state : {MatchState::kOk, MatchState::kLost}) {
    const ScanMatch match = MatchAfter(tracking, Answer(state), {}, kPeriod_us, Pose2{0.3, 0.1, 0.2});
    REQUIRE(match.by_wheels);
    CheckPose(match.by_wheels->T_from_to, {0.3, 0.1, 0.2}, 1e-9);
  }
  CHECK_FALSE(MatchAfter(tracking, Answer(MatchState::kOk)).by_wheels);
}

TEST_CASE("a match is of the trajectory of the last one; one that begins a trajectory is of the next, and floats") {
  TrackingState tracking = After(2);
  const bool floats = GENERATE(true, false);
  tracking.Add(Answer(MatchState::kLost), {std::nullopt, 4, floats});
  const ScanMatch on = MatchAfter(tracking, Answer(MatchState::kOk));
  REQUIRE(on.state == MatchState::kOk);
  CHECK(on.trajectory == 4);
  CHECK(on.floating == floats);
  const ScanMatch first = MatchAfter(tracking, Answer(MatchState::kLost));
  REQUIRE(first.state == MatchState::kFirst);
  CHECK(first.trajectory == 5);
  CHECK(first.floating);
  tracking.BeginSession(Onset::kAnywhere);
  CHECK(MatchAfter(tracking, Answer(MatchState::kOk)).trajectory == 5);
}

TEST_CASE("while the map is empty each first scan is of the first trajectory of all, also after a gap") {
  TrackingState tracking;
  for (const std::int64_t utime : {0, 1, 2}) Add(tracking, MatchState::kFirst, {}, utime * kPeriod_us);
  ScanMatch empty = Answer(MatchState::kFirst, {5.0, 0.0, 0.0});
  empty.covariance = {};
  const ScanMatch first = MatchAfter(tracking, empty, {}, 600'000'000);
  CHECK(first.state == MatchState::kFirst);
  CHECK(first.T_map_laser == Pose2{});
  CHECK(first.trajectory == 0);
  CHECK_FALSE(first.floating);
  CHECK(first.covariance == ScanMatch().covariance);  // it is the origin
}

TEST_CASE("a trajectory begins where the known map shows the scan to be, and floats all the same") {
  const Pose2 place{7.0, -3.0, 2.0};
  ToldMatcher matcher(Answer(MatchState::kLost));
  matcher.SetLocated(place);
  const auto Match = [&](const TrackingState& tracking, std::int64_t later_us,
                         const std::optional<Pose2>& T_odom_robot = std::nullopt) {
    return MatchScan(matcher, ScanAfter(tracking, later_us), tracking, T_odom_robot, {});
  };
  CHECK(Match(After(1), kPeriod_us).state == MatchState::kLost);
  for (const ScanMatch& first : {Match(After(2), kPeriod_us), Match(After(0), 200 * kPeriod_us)}) {
    CHECK(first.state == MatchState::kFirst);
    CHECK(first.T_map_laser == place);
    CHECK(first.floating);
    CHECK(first.covariance[0] == kUnknownVariance);
  }
  CHECK(Match(After(2, Pose2{}), kPeriod_us, Pose2{}).T_map_laser == kPlace);  // wheels tell more than one scan
  matcher.SetLocated(kPlace * Pose2{3.0, 0.0, 0.0});
  const ScanMatch near = Match(After(2), kPeriod_us);
  CHECK(near.T_map_laser == kPlace);
  CHECK(near.covariance[0] < 10.0);
}

TEST_CASE(
    "no trajectory begins on a finished map, without loops, where that is switched off, nor with hardly any rays") {
  const ScanMatch lost = Answer(MatchState::kLost);
  MatchOptions options;
  options.loops = false;
  CHECK(MatchAfter(After(5), lost, options).state == MatchState::kLost);
  TrackingState finished = TrackingState::OnFinishedMap();
  for (int i = 0; i < 10; ++i) finished.Add(lost);
  CHECK(MatchAfter(finished, lost).state == MatchState::kLost);
  const TrackingState tracking = After(5);
  for (const int num_beams : {2, 19}) {
    const CriticalRays scan = ScanAfter(tracking, kPeriod_us, num_beams);
    CHECK(MatchScan(ToldMatcher(lost), scan, tracking, std::nullopt, {}).state == MatchState::kLost);
  }
}

TEST_CASE("after lost scans one that fits badly is lost too, and leaves nothing of its match") {
  const ScanMatch bad = Answer(MatchState::kDegenerate, {4.0, 2.0, 0.5}, 0.47);  // of 0.8, less than 60 %
  const ScanMatch match = MatchAfter(After(1), bad);
  CHECK(match.state == MatchState::kLost);
  CHECK(match.T_map_laser == kPlace);
  CHECK(match.degenerate_axis == ScanMatch().degenerate_axis);
  CHECK(match.covariance == ComputeGuessCovariance(match, After(1)));
  CHECK(MatchAfter(After(2), bad).state == MatchState::kFirst);
  CHECK(MatchAfter(After(0), bad).state == MatchState::kDegenerate);
  CHECK(MatchAfter(After(1), Answer(MatchState::kOk, {4.0, 2.0, 0.5}, 0.49)).state == MatchState::kOk);
  // So near to where it was last, no window has grown.
  CHECK(MatchAfter(After(2), Answer(MatchState::kOk, {1.3, 2.0, 0.4}, 0.3)).state == MatchState::kOk);
  CHECK(MatchAfter(After(1), Answer(MatchState::kOk, {1.3, 2.0, 0.9}, 0.3)).state == MatchState::kLost);
}

TEST_CASE("after a gap, or where the clock begins anew, a trajectory does, unless the robot stands where it stood") {
  const ScanMatch elsewhere = Answer(MatchState::kOk, {1.0, 2.45, 0.5});
  const TrackingState tracking = After(0);
  MatchOptions without_loops;
  without_loops.loops = false;
  MatchOptions without_gaps;
  without_gaps.constants.breaks.gap_max_s = 1e9;
  struct Break {
    std::int64_t later_us, too_small_us;
    MatchOptions never;
    MatchState with_wheels;  ///< which tell how it moved in a gap, but not when
  };
  for (const auto& [later_us, too_small_us, never, with_wheels] :
       {Break{9'000'000, 7'900'000, without_gaps, MatchState::kOk},
        Break{-8'000'001, -8'000'000, without_loops, MatchState::kFirst}}) {  // logs step back by a second
    CAPTURE(later_us);
    for (const ScanMatch& answer : {elsewhere, Answer(MatchState::kOk, {1.0, 2.0, 0.8}),
                                    Answer(MatchState::kOk, kPlace, 0.7), Answer(MatchState::kLost)}) {
      const ScanMatch first = MatchAfter(tracking, answer, {}, later_us);
      CHECK(first.state == MatchState::kFirst);
      CHECK(first.T_map_laser == kPlace);
    }
    const ScanMatch near = Answer(MatchState::kOk, {1.0, 2.2, 0.6});
    CHECK(MatchAfter(tracking, near, {}, later_us).state == MatchState::kOk);
    CHECK(MatchAfter(tracking, elsewhere, {}, too_small_us).state == MatchState::kOk);
    CHECK(MatchAfter(tracking, elsewhere, never, later_us).state == MatchState::kOk);
    CHECK(MatchAfter(After(0, Pose2{}), elsewhere, {}, later_us, Pose2{}).state == with_wheels);
  }
  TrackingState seldom;  // such a step is no gap
  for (int i = 0; i < 10; ++i) Add(seldom, MatchState::kOk, kPlace, i * 3'000'000);
  CHECK(MatchAfter(seldom, elsewhere, {}, 20'000'000).state == MatchState::kOk);
  CHECK(MatchAfter(seldom, elsewhere, {}, 25'000'000).state == MatchState::kFirst);
}

TEST_CASE("another drive begins a trajectory whatever fits, and is lost before a scan that can begin one") {
  const ScanMatch here = Answer(MatchState::kOk);
  TrackingState tracking = After(0);
  tracking.BeginSession(Onset::kAnywhere);
  ScanMatch first = MatchAfter(tracking, here);
  CHECK(first.state == MatchState::kFirst);
  CHECK(first.T_map_laser == kPlace);
  CHECK(first.covariance[0] == kUnknownVariance);
  CHECK(MatchScan(ToldMatcher(here), ScanAfter(tracking, kPeriod_us, 19), tracking, std::nullopt, {}).state ==
        MatchState::kLost);
  tracking.BeginSessionNear({7.0, 8.0, 0.1});
  first = MatchAfter(tracking, here);
  CHECK(first.state == MatchState::kFirst);
  CHECK(first.T_map_laser == Pose2{7.0, 8.0, 0.1});
  CHECK(first.covariance[0] == Approx(0.35 * 0.35));
}

TEST_CASE("a session on an earlier map goes on where its first scan fits, else begins a trajectory at once") {
  TrackingState tracking = After(0);
  tracking.BeginSession(Onset::kResumed);
  CHECK(MatchAfter(tracking, Answer(MatchState::kOk)).state == MatchState::kOk);
  const ScanMatch first = MatchAfter(tracking, Answer(MatchState::kLost));
  CHECK((first.state == MatchState::kFirst && first.T_map_laser == kPlace));
  CHECK(first.covariance == ComputeGuessCovariance(first, tracking));
  CHECK(first.covariance[0] < kUnknownVariance);  // else it would not be looked for nearby
}

}  // namespace crsm
