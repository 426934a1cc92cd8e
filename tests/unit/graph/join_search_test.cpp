#include "common/graph/join_search.hpp"

#include "catch.hpp"
#include "common/worlds/world.hpp"
#include "graph/block.hpp"

namespace crsm {
namespace {

/// Drives along a line through the block's lower corridor: a trajectory of keyframes, 0.4 m apart, each matched well.
/// guess: where the first is taken to be.
void Drive(KeyframeGraph& graph, const std::vector<Wall>& walls, Pose2 from, double length_m, const Pose2& guess,
           std::int64_t utime) {
  constexpr double kStep_m = 0.4;
  Random random(static_cast<std::uint64_t>(utime) + 1);
  for (int i = 0; i * kStep_m <= length_m; ++i) {
    Keyframe keyframe;
    keyframe.utime = utime + i * 400'000;
    keyframe.rays = SeeRays(walls, from, random);
    keyframe.begins = i == 0;
    keyframe.T_previous_this = i == 0 ? guess : Pose2{kStep_m, 0.0, 0.0};
    graph.Add(keyframe);
    from = from * Pose2{kStep_m, 0.0, 0.0};
  }
}

}  // namespace

TEST_CASE("a robot that was carried is found in what another trajectory saw, whichever way it looks") {
  const std::vector<Wall> walls = MakeBlock(3);
  for (const double yaw_rad : {0.0, kPi}) {
    KeyframeGraph graph;
    Drive(graph, walls, {2.0, 1.5, 0.0}, 24.0, {}, 0);
    const Pose2 begin = yaw_rad == 0.0 ? Pose2{8.0, 1.4, 0.0} : Pose2{22.0, 1.6, kPi};
    Drive(graph, walls, begin, 8.0, {3.0, 5.0, 1.0}, 60'000'000);
    JoinSearch search{GraphConstants{}};
    const auto finding = search.Search(graph, {});
    REQUIRE(finding);
    CHECK(finding->by == LoopFinding::By::kAnywhere);
    CHECK(finding->newer == *graph.newest());
    const Pose2 older{2.0 + graph.path_m(finding->older), 1.5, 0.0};
    const Pose2 newer = begin * Pose2{8.0, 0.0, 0.0};
    const Pose2 error = Inverse(Inverse(older) * newer) * finding->T_older_newer;
    CHECK(Length(error) < 0.2);
    CHECK(std::abs(error.yaw_rad) < 0.02);
    CHECK(JoinSearch{GraphConstants{}}.Search(graph, {})->T_older_newer == search.Search(graph, {})->T_older_newer);
  }
}

TEST_CASE("of more submaps than are searched at a time each takes its turn, near a place found before always") {
  const std::vector<Wall> walls = MakeBlock(3);
  GraphConstants constants;
  constants.joins.most_drawn = 1;
  int num_found = 0;
  for (const double length_m : {8.0, 11.2, 14.0, 17.2}) {
    CAPTURE(length_m);
    KeyframeGraph graph;
    Drive(graph, walls, {2.0, 1.5, 0.0}, 24.0, {}, 0);
    Drive(graph, walls, {5.0, 1.4, 0.0}, length_m, {3.0, 5.0, 1.0}, 60'000'000);
    if (JoinSearch(constants).Search(graph, {})) ++num_found;
    CHECK(JoinSearch(constants).Search(graph, {{0, 40}}));
  }
  CHECK(num_found >= 1);
  CHECK(num_found < 4);
}

TEST_CASE("nothing is found in a building that the robot was not in") {
  KeyframeGraph graph;
  Drive(graph, MakeBlock(3), {2.0, 1.5, 0.0}, 24.0, {}, 0);
  Drive(graph, MakeBlock(4), {8.0, 1.5, 0.0}, 8.0, {30.0, 5.0, 1.0}, 60'000'000);
  CHECK_FALSE(JoinSearch{GraphConstants{}}.Search(graph, {}));
}

TEST_CASE("soon after a short break the robot is looked for near where it was, and one finding is enough") {
  const std::vector<Wall> walls = MakeBlock(3);
  KeyframeGraph graph;
  Drive(graph, walls, {2.0, 1.5, 0.0}, 12.0, {}, 0);
  Drive(graph, walls, {14.6, 1.6, 0.05}, 0.4, {0.8, 0.0, 0.0}, 13'000'000);  // 0.2 m further than guessed
  const auto finding = JoinSearch{GraphConstants{}}.Search(graph, {});
  REQUIRE(finding);
  CHECK(finding->by == LoopFinding::By::kSoon);
  CHECK(finding->score >= GraphConstants().joins.sure_score);
}

}  // namespace crsm
