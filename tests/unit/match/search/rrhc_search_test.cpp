#include "common/match/search/rrhc_search.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "check_pose.hpp"
#include "hill.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

const MotionBounds kWindow{0.5, 0.3};
constexpr double kNever = 10.0;  // more than any fitness

/// A search that only its budget ends.
constexpr MatchConstants::Search kSearch;

/// A search on a landscape, and what it asked for.
template <class Landscape>
struct TestSearch {
  explicit TestSearch(Landscape landscape, std::uint64_t seed = 1)
      : random(seed),
        search(
            kSearch,
            [this, landscape](const Pose2& pose) {
              asked.push_back(pose);
              return landscape(pose);
            },
            random) {}

  Random random;
  RrhcSearch search;
  std::vector<Pose2> asked;
};

const Pose2 kNear{0.2, -0.3, 0.1};

}  // namespace

TEST_CASE("a climb of shrinking steps comes to the top") {
  TestSearch test(OneHill);
  const ScoredPose best = test.search.Run({{}, kWindow, 1, 5000, kNever}).best;
  CheckPose(best.pose, kTop, 0.01);
  CHECK(best.fitness == OneHill(best.pose));
}

TEST_CASE("restarts find the higher hill behind the one at which the search begins") {
  const auto TwoHills = [](const Pose2& pose) { return std::max(Hill(pose, {}, 0.5), Hill(pose, kTop, 0.8)); };
  TestSearch test(TwoHills);
  CheckPose(test.search.Run({{}, kWindow, 1, 5000, kNever}).best.pose, kTop, 0.05);
}

TEST_CASE("a search is over after its first climbs if the best is good enough, and goes on if it is not") {
  TestSearch enough(OneHill);
  CHECK(enough.search.Run({kNear, kWindow, 1, 100000, 0.9}).evaluations < 1000);
  TestSearch not_enough(OneHill);
  CHECK(not_enough.search.Run({kNear, kWindow, 1, 100000, 1.01}).evaluations == 100000);
}

TEST_CASE("a search that is never satisfied spends the evaluations that it may, and no more") {
  for (const int num_draws : {1, 30}) {
    for (const int num_evaluations : {1, 2, 999, 1000, 1001, 1003}) {
      TestSearch test(OneHill);
      const SearchResult found = test.search.Run({{}, kWindow, num_draws, num_evaluations, kNever});
      CHECK(test.asked.size() == static_cast<std::size_t>(num_evaluations));
      CHECK(found.evaluations == num_evaluations);
      REQUIRE(found.best_evaluation >= 1);
      REQUIRE(found.best_evaluation <= num_evaluations);
      CHECK(test.asked[static_cast<std::size_t>(found.best_evaluation) - 1] == found.best.pose);
    }
  }
}

TEST_CASE("a second run of a search goes on with the random numbers of the first, and counts anew") {
  TestSearch test(OneHill);
  for (int run = 0; run < 2; ++run) CHECK(test.search.Run({{}, kWindow, 1, 500, kNever}).evaluations == 500);
  REQUIRE(test.asked.size() == 1000);
  CHECK(test.asked[0] == test.asked[500]);  // the initial guess
  CHECK_FALSE(test.asked[1] == test.asked[501]);
}

TEST_CASE("the same random numbers make the same search") {
  TestSearch one(OneHill, 7);
  TestSearch same(OneHill, 7);
  TestSearch other(OneHill, 8);
  const SearchTask task{{}, kWindow, 30, 3000, kNever};
  const ScoredPose best = one.search.Run(task).best;
  CHECK(best.pose == same.search.Run(task).best.pose);
  CHECK(one.asked == same.asked);
  CHECK_FALSE(best.pose == other.search.Run(task).best.pose);
}

TEST_CASE("on a plain a search stays where it is guessed, and its climbs end") {
  const auto Plain = [](const Pose2&) { return 0.5; };
  for (const int num_draws : {1, 30}) {
    TestSearch test(Plain);
    const SearchResult found = test.search.Run({kNear, kWindow, num_draws, 10000, 0.4});
    CHECK(found.best.pose == kNear);
    CHECK(found.best_evaluation == 1);
    CHECK(found.evaluations == 1 + 38);  // one climb, over when 0.9^n < 0.02, n = 38
  }
}

}  // namespace crsm
