#include "common/match/paper_matcher.hpp"

#include "catch.hpp"
#include "check_pose.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

const std::vector<ScanMatch> kAtOrigin{{1, {}, 0.0, 0, 0, 0, MatchState::kFirst}};

PaperMatcher MatcherInRoom(const PaperMatchConstants& constants = {.num_evaluations = 50000}, std::uint64_t seed = 1) {
  PaperMatcher matcher(seed, 0.05, constants);
  REQUIRE(matcher.Apply(PaintTiles(-1, 1, RoomByte)));
  return matcher;
}

ScanMatch MatchAt(const PaperMatcher& matcher, const Pose2& truth) {
  return matcher.Match(RaysOf(ScanRoom(truth, 2)), After(kAtOrigin), {});
}

}  // namespace

TEST_CASE("the paper's matcher finds a scan within its window to a cell") {
  for (const Pose2& truth : {Pose2{}, {-0.3, 0.25, 0.15}, {0.2, -0.35, -0.2}, {0.0, 0.0, 0.24}}) {
    CAPTURE(truth.x_m, truth.y_m, truth.yaw_rad);
    const ScanMatch match = MatchAt(MatcherInRoom(), truth);
    CHECK(match.state == MatchState::kOk);
    CheckPose(match.T_map_laser, truth, 0.05);
  }
}

TEST_CASE("the paper's matcher spends the evaluations that it may, and says how the match came about") {
  const ScanMatch match = MatchAt(MatcherInRoom(), {0.05, 0.0, 0.0});
  CHECK(match.utime == 2);
  CHECK(match.evaluations == 50000);
  CHECK(match.best_evaluation >= 1);
  CHECK(match.best_evaluation <= 50000);
  CHECK(match.num_critical > 0);
  CHECK(match.fitness > 0.85);  // a wall cell has two wall cells, a free and an unexplored one beside it: 3188 of 3570
  CHECK(match.fitness <= 1.0);
  CHECK(MatchAt(MatcherInRoom({.satisfying_fitness = 0.3}), {}).evaluations < 100);
}

TEST_CASE("the paper's matcher gives the same match for the same seed, bit for bit") {
  const Pose2 truth{0.1, -0.1, 0.1};
  const ScanMatch match = MatchAt(MatcherInRoom(), truth);
  CHECK(MatchAt(MatcherInRoom(), truth) == match);
  CHECK_FALSE(MatchAt(MatcherInRoom({.num_evaluations = 50000}, 2), truth) == match);
}

TEST_CASE("the paper's matcher punishes what is unexplored") {
  PaperMatcher matcher(1, 0.05);
  REQUIRE(matcher.Apply(PaintTiles(0, 0, [](Cell cell) { return cell.x < 32 ? kFreeByte : kUnexploredByte; })));
  const CriticalRays scan{2, {{0.0f}, {1.0f}}, {0}};  // one beam of a metre, from the middle of what is known
  const ScanMatch match = matcher.Match(scan, After({MatchedAt(1, {0.9, 0.9, 0.0})}), {});
  CHECK(match.T_map_laser.x_m < 0.61);  // where it ends in known cells
}

TEST_CASE("the paper's first scan is the origin of the map, and a scan without rays is lost where it was guessed") {
  const ScanMatch first = PaperMatcher(1, 0.05).Match(RaysOf(ScanRoom({0.1, 0.2, 0.3}, 2)), {}, {});
  CHECK(first.state == MatchState::kFirst);
  CHECK(first.T_map_laser == Pose2{});
  const ScanMatch lost = MatcherInRoom().Match({9, {}, {}}, After({MatchedAt(1, {1.0, 2.0, 0.5})}), {});
  CHECK(lost.state == MatchState::kLost);
  CHECK(lost.T_map_laser == Pose2{1.0, 2.0, 0.5});
}

}  // namespace crsm
