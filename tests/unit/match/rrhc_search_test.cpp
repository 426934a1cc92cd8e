#include "common/match/rrhc_search.hpp"

#include <algorithm>
#include <vector>

#include "catch.hpp"
#include "check_pose.hpp"
#include "hill.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

const MotionBounds kWindow{0.5, 0.3};
constexpr double kNever = 10.0;  // more than any fitness

/// The parameters of a search that only its budget ends.
MatchParameters Endless(ClimbMode climb = ClimbMode::kShrinking) {
  MatchParameters parameters = TestParameters().match;
  parameters.climb = climb;
  parameters.satisfying_fitness = kNever;
  return parameters;
}

/// A search on a landscape, and what it asked for.
template <class Landscape>
struct TestSearch {
  TestSearch(const MatchParameters& match, Landscape landscape, std::uint64_t seed = 1)
      : parameters(match),
        search(
            parameters,
            [this, landscape](const Pose2& pose) {
              asked.push_back(pose);
              return landscape(pose);
            },
            Random(seed)) {}

  MatchParameters parameters;
  RrhcSearch search;
  std::vector<Pose2> asked;
};

const Pose2 kNear{0.2, -0.3, 0.1};

}  // namespace

TEST_CASE("a climb of shrinking steps comes to the top") {
  TestSearch test(Endless(), OneHill);
  const Individual best = test.search.Run({}, kWindow, 1, 5000, kNever);
  CheckPose(best.pose, kTop, 0.01);
  CHECK(best.fitness == OneHill(best.pose));
}

TEST_CASE("restarts find the higher hill behind the one at which the search begins") {
  const auto TwoHills = [](const Pose2& pose) { return std::max(Hill(pose, {}, 0.5), Hill(pose, kTop, 0.8)); };
  TestSearch test(Endless(), TwoHills);
  CheckPose(test.search.Run({}, kWindow, 1, 5000, kNever).pose, kTop, 0.05);
}

TEST_CASE("a search is over after its first climbs if the best is good enough, and goes on if it is not") {
  TestSearch enough(Endless(), OneHill);
  enough.search.Run(kNear, kWindow, 1, 100000, 0.9);
  CHECK(enough.search.evaluations() < 1000);
  TestSearch not_enough(Endless(), OneHill);
  not_enough.search.Run(kNear, kWindow, 1, 100000, 1.01);
  CHECK(not_enough.search.evaluations() == 100000);
}

TEST_CASE("a search that is never satisfied spends the evaluations that it may, and no more") {
  for (const ClimbMode climb : {ClimbMode::kFixed, ClimbMode::kShrinking}) {
    for (const int num_draws : {1, 30}) {
      for (const int num_evaluations : {1, 2, 999, 1000, 1001, 1003}) {
        TestSearch test(Endless(climb), OneHill);
        const Individual best = test.search.Run({}, kWindow, num_draws, num_evaluations, kNever);
        CHECK(test.asked.size() == static_cast<std::size_t>(num_evaluations));
        CHECK(test.search.evaluations() == num_evaluations);
        const auto found = static_cast<std::size_t>(test.search.best_evaluation());
        REQUIRE(found >= 1);
        REQUIRE(found <= test.asked.size());
        CHECK(test.asked[found - 1] == best.pose);
      }
    }
  }
}

TEST_CASE("a second run of a search goes on with the random numbers and the count of the first") {
  TestSearch test(Endless(), OneHill);
  test.search.Run({}, kWindow, 1, 500, kNever);
  test.search.Run({}, kWindow, 1, 500, kNever);
  CHECK(test.search.evaluations() == 1000);
  CHECK(test.asked[0] == test.asked[500]);  // the presumed pose
  CHECK_FALSE(test.asked[1] == test.asked[501]);
}

TEST_CASE("the same random numbers make the same search") {
  TestSearch one(Endless(), OneHill, 7);
  TestSearch same(Endless(), OneHill, 7);
  TestSearch other(Endless(), OneHill, 8);
  const Individual best = one.search.Run({}, kWindow, 30, 3000, kNever);
  CHECK(best.pose == same.search.Run({}, kWindow, 30, 3000, kNever).pose);
  CHECK(one.asked == same.asked);
  CHECK_FALSE(best.pose == other.search.Run({}, kWindow, 30, 3000, kNever).pose);
}

}  // namespace crsm
