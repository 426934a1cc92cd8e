#include "common/match/guess/tracking_state.hpp"

#include "catch.hpp"
#include "check_pose.hpp"

namespace crsm {
namespace {

ScanMatch Match(std::int64_t utime, double fitness, MatchState state) {
  return {utime, {0.1 * static_cast<double>(utime), 0.0, 0.0}, fitness, 1, 1, 0, state};
}

}  // namespace

TEST_CASE("before the first scan nothing is remembered") {
  for (const TrackingState& state : {TrackingState(), TrackingState::OnFinishedMap()}) {
    CHECK(state.empty());
    CHECK(state.num_lost() == 0);
    CHECK(state.baseline_fitness() == 0.0);
    CHECK(state.recent().empty());
    CHECK(state.newest_utime() == -1);
  }
  CHECK_FALSE(TrackingState().on_finished_map());
  CHECK(TrackingState::OnFinishedMap().on_finished_map());
}

TEST_CASE("a robot that is told where it is stands there, and is lost no more") {
  TrackingState state = TrackingState::OnFinishedMap();
  for (int i = 1; i < 5; ++i) state.Add(Match(i, 0.5, i < 3 ? MatchState::kOk : MatchState::kLost));
  const TrackingState moved = state.MovedTo({7.0, 8.0, 0.5});
  REQUIRE(moved.recent().size() == 1);
  CHECK(moved.recent().back().T_map_laser == Pose2{7.0, 8.0, 0.5});
  CHECK(moved.recent().back().state == MatchState::kOk);
  CHECK(moved.recent().back().utime == 4);
  CHECK(moved.num_lost() == 0);
  CHECK(moved.baseline_fitness() == state.baseline_fitness());
  CHECK((moved.on_finished_map() && moved.num_scans() == 4));
  const TrackingState none = TrackingState::OnFinishedMap();
  CHECK(none.MovedTo({7.0, 8.0, 0.5}) == none);
}

TEST_CASE("how a session begins holds until a scan is placed, and its place moves with the map") {
  TrackingState state;
  state.BeginSession(Onset::kResumed);
  CHECK(state.onset() == Onset::kGoesOn);  // on no map yet
  state.Add(Match(10, 0.5, MatchState::kOk));
  state.BeginSession(Onset::kResumed);
  CHECK(state.onset() == Onset::kResumed);
  state.Add(Match(11, 0.0, MatchState::kLost));
  CHECK(state.onset() == Onset::kResumed);
  state.Add(Match(12, 0.5, MatchState::kOk));
  CHECK(state.onset() == Onset::kGoesOn);
  state.BeginSession(Onset::kAnywhere);
  CHECK(state.T_map_guess() == state.recent().back().T_map_laser);
  state.BeginSessionNear({3.0, 4.0, 0.5});
  state.Add(Match(7, 0.0, MatchState::kLost), {Pose2{1.0, 0.0, 0.0}});
  CHECK(state.newest_utime() == 12);  // clocks step back
  CHECK(state.onset() == Onset::kNear);
  CHECK(state.T_map_guess() == Pose2{4.0, 4.0, 0.5});
  state.Add(Match(14, 0.0, MatchState::kFirst));
  CHECK(state.onset() == Onset::kGoesOn);
  CHECK(state.T_map_guess() == Pose2{});
}

TEST_CASE(
    "the baseline fitness is the mean of the last ten scans that were matched; first and lost ones do not count") {
  TrackingState state;
  state.Add(Match(0, 0.0, MatchState::kFirst));
  CHECK(state.baseline_fitness() == 0.0);
  state.Add(Match(1, 0.3, MatchState::kOk));
  state.Add(Match(2, 0.9, MatchState::kLost));
  state.Add(Match(3, 0.5, MatchState::kDegenerate));
  CHECK(state.baseline_fitness() == Approx(0.4));
  for (int k = 4; k < 14; ++k) state.Add(Match(k, 0.05 * k, MatchState::kOk));
  CHECK(state.baseline_fitness() == Approx(0.05 * (4 + 13) / 2.0));
  for (int k = 14; k < 2000; ++k) state.Add(Match(k, 0.1, MatchState::kLost));
  CHECK(state.baseline_fitness() == Approx(0.05 * (4 + 13) / 2.0));  // for ever, if need be
  state.Add(Match(2000, 0.0, MatchState::kFirst));
  CHECK(state.baseline_fitness() == 0.0);  // a new trajectory has a map of its own
  state.Add(Match(2001, 0.7, MatchState::kOk));
  CHECK(state.baseline_fitness() == Approx(0.7));
}

TEST_CASE("how far the motion before tells the next place wrongly is learned from scans whose place the walls tell") {
  const auto LearnFrom = [](MatchState state, auto&& x_m) {
    TrackingState learned;
    learned.Add({0, {x_m(0), 0.0, 0.0}, 0.8, 1, 1, 0, MatchState::kFirst});
    for (int k = 1; k < 500; ++k) learned.Add({100'000 * k, {x_m(k), 0.0, 0.0}, 0.8, 1, 1, 0, state});
    return learned.motion_error_m();
  };
  const auto Evenly = [](int k) { return 0.05 * k; };
  const auto Jerkily = [](int k) { return 0.05 * k + (k % 2 == 0 ? 0.02 : -0.02); };
  const auto Stands = [](int) { return 1.0; };
  CHECK(LearnFrom(MatchState::kOk, Evenly) < 0.001);
  CHECK(LearnFrom(MatchState::kOk, Jerkily) > 0.01);
  CHECK(LearnFrom(MatchState::kOk, Stands) == MatchConstants::Tracking{}.first_motion_error_m);
  CHECK(LearnFrom(MatchState::kDegenerate, Evenly) == MatchConstants::Tracking{}.first_motion_error_m);
}

TEST_CASE(
    "the last ten matches are remembered, oldest first, and found by their utime; those lost in a row are counted") {
  TrackingState state;
  for (int k = 0; k < 1000; ++k) {
    state.Add(Match(k, 0.5, k % 40 < 30 ? MatchState::kLost : MatchState::kOk));
    CHECK(state.num_lost() == (k % 40 < 30 ? k % 40 + 1 : 0));
    CHECK(state.num_scans() == k + 1);
  }
  REQUIRE(state.recent().size() == 10);
  for (int k = 0; k < 10; ++k) CHECK(state.recent()[static_cast<std::size_t>(k)].utime == 990 + k);
  REQUIRE(state.FindRecent(993));
  CHECK(*state.FindRecent(993) == state.recent()[3]);
  for (const std::int64_t utime : {989, 1000}) CHECK_FALSE(state.FindRecent(utime));
}

TEST_CASE("the trajectory is that of the map after the last match, else that of the match") {
  TrackingState state;
  CHECK(state.trajectory() == 0);
  CHECK_FALSE(state.floating());
  ScanMatch match = Match(1, 0.5, MatchState::kFirst);
  match.trajectory = 3;
  match.floating = true;
  state.Add(match);
  CHECK(state.trajectory() == 3);
  CHECK(state.floating());
  state.Add(match, {std::nullopt, 2, false});
  CHECK(state.trajectory() == 2);
  CHECK_FALSE(state.floating());
}

TEST_CASE(
    "a map that is moved takes the last scans along, and in the frame that never jumps they stay where they are") {
  TrackingState state;
  std::vector<ScanMatch> matched;
  for (int k = 0; k < 5; ++k) {
    matched.push_back(Match(k, 0.5, MatchState::kOk));
    state.Add(matched.back());
  }
  CHECK(state.T_local_map() == Pose2{});
  for (const Pose2& T_new_old : {Pose2{1.0, -2.0, 0.5}, Pose2{0.25, 30.0, -3.0}}) {
    const Pose2 T_local_map = state.T_local_map();
    matched.push_back(Match(std::ssize(matched), 0.5, MatchState::kOk));
    state.Add(matched.back(), {T_new_old});
    REQUIRE(state.recent().size() == matched.size());
    for (std::size_t i = 0; i < matched.size(); ++i) {
      ScanMatch& before = matched[i];
      const ScanMatch& match = state.recent()[i];
      CheckPose(match.T_map_laser, T_new_old * before.T_map_laser, 1e-9);
      CheckPose(state.T_local_map() * match.T_map_laser, T_local_map * before.T_map_laser, 1e-9);
      before.T_map_laser = match.T_map_laser;
      CHECK(match == before);
    }
  }
  CHECK(state.num_scans() == std::ssize(matched));
  CHECK(state.baseline_fitness() == Approx(0.5));
}

}  // namespace crsm
