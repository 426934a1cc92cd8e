#include "common/graph/loop_search.hpp"

#include "catch.hpp"
#include "common/graph/submap_loop_closer.hpp"
#include "graph/block.hpp"

namespace crsm {
namespace {

constexpr double kLocalMap_m = 40.0;

/// What a robot saw on a part of the way round the block, and where it is taken to have been then.
struct Part {
  double from_m;
  double to_m;
  Pose2 T_map_world;
};

/// A path of such parts.
KeyframeGraph MakeGraph(const std::vector<Part>& parts) {
  const std::vector<Wall> walls = MakeBlock(3);
  Random random(3, 5);
  KeyframeGraph graph;
  Pose2 last;
  for (const Part& part : parts) {
    for (const Pose2& place : DriveRoundBlock(part.from_m, part.to_m)) {
      const Pose2 pose = part.T_map_world * place;
      Keyframe keyframe;
      keyframe.rays = SeeRays(walls, place, random);
      keyframe.T_previous_this = Inverse(last) * pose;
      graph.Add(std::move(keyframe));
      last = pose;
    }
  }
  return graph;
}

const Part kPlace{5.0, 20.0, {}};
const Part kElsewhere{25.0, 50.0, {}};
const Part kFarther{50.0, 80.0, {}};

}  // namespace

TEST_CASE("a place is found where it was seen long ago") {
  const Pose2 drift{0.8, 0.6, 0.03};
  const KeyframeGraph graph = MakeGraph({kPlace, kElsewhere, kFarther, {5.0, 18.0, drift}});
  const auto finding = SearchLoop(graph, kLocalMap_m, false, {});
  REQUIRE(finding);
  CHECK(finding->by == LoopFinding::By::kDrift);
  CHECK(finding->newer == *graph.newest());
  // It lies where it was first, not where the path leads to.
  const Pose2 found = graph.pose(finding->older) * finding->T_older_newer;
  const Pose2 first = Inverse(PlaceRoundBlock(5.0)) * PlaceRoundBlock(18.0);
  CHECK(std::hypot(found.x_m - first.x_m, found.y_m - first.y_m) < 0.15);

  MatchConstants match;
  match.map_search.other_place = {0.0, 0.0};  // each pose beside it is another place, and a rival
  CHECK_FALSE(SearchLoop(graph, kLocalMap_m, false, {{}, match}));
}

TEST_CASE("of two places that are alike none is taken, though each of them is the only one in its part of the path") {
  const Pose2 aside{1.4, 1.4, 0.0};
  const Pose2 between{0.7, 0.7, 0.0};
  const KeyframeGraph graph =
      MakeGraph({kPlace, kElsewhere, {5.0, 20.0, aside}, kFarther, {25.0, 40.0, {}}, {5.0, 18.0, between}});
  CHECK_FALSE(SearchLoop(graph, kLocalMap_m, false, {}));
}

TEST_CASE("further away than poses drift as a rule a place is found by a thorough search") {
  const KeyframeGraph graph = MakeGraph({kPlace, kElsewhere, kFarther, {5.0, 18.0, {1.8, 1.0, 0.03}}});
  CHECK_FALSE(SearchLoop(graph, kLocalMap_m, false, {}));
  CHECK(SearchLoop(graph, kLocalMap_m, true, {}));
}

TEST_CASE("after a long way along the graph a place is found as far away as poses drift over it") {
  const Pose2 drift{20.0, 8.0, 0.3};
  const auto FoundAfter = [&](double there_m) {
    const KeyframeGraph graph = MakeGraph({kPlace, {25.0, 50.0, {there_m, 0.0, 0.0}}, {5.0, 18.0, drift}});
    return SearchLoop(graph, kLocalMap_m, true, {});
  };
  CHECK_FALSE(FoundAfter(300.0));
  const auto finding = FoundAfter(650.0);
  REQUIRE(finding);
  const Pose2 error = Inverse(Inverse(PlaceRoundBlock(5.0 + 0.5 * finding->older.number)) * PlaceRoundBlock(18.0)) *
                      finding->T_older_newer;
  CHECK(std::hypot(error.x_m, error.y_m) < 0.15);
}

TEST_CASE("a place is not taken if one that is alike lies further away than poses drift as a rule") {
  const Pose2 near{0.2, 0.2, 0.0};
  const auto Found = [&](const Part& again) {
    return SearchLoop(MakeGraph({kPlace, kElsewhere, again, kFarther, {25.0, 40.0, {}}, {5.0, 18.0, near}}),
                      kLocalMap_m, false, {})
        .has_value();
  };
  CHECK(Found({50.0, 60.0, {}}));
  CHECK_FALSE(Found({5.0, 20.0, {2.4, 0.4, 0.0}}));
}

TEST_CASE("findings that do not agree on how the robot has moved close no loop") {
  const std::vector<Pose2> places = DriveRoundBlock(5.0, 5.0 + 1.4 * kRoundBlock_m);
  const auto FirstLoops = [](const std::vector<Keyframe>& keyframes) {
    SubmapLoopCloser closer({true, kLocalMap_m}, UpdateParameters{});
    for (const Keyframe& keyframe : keyframes) {
      const auto update = closer.Add(keyframe, {});
      if (update && update->ChangesGraph()) return update->closed;
    }
    return std::vector<Loop>();
  };
  auto keyframes = MakeKeyframes(MakeBlock(5), places, {0.002, 0.0, 0.0008}, 5);
  const std::vector<Loop> loops = FirstLoops(keyframes);
  REQUIRE(loops.size() == 2);

  // Behind the first finding the wheels slip, say: from there on the robot is 0.5 m behind.
  const int slip = loops[0].newer.number + 1;
  REQUIRE(slip < loops[1].newer.number);
  auto& motion = keyframes[static_cast<std::size_t>(slip)].T_previous_this;
  motion = motion * Pose2{-0.5, 0.0, 0.0};
  const std::vector<Loop> later = FirstLoops(keyframes);
  REQUIRE(later.size() == 2);
  CHECK(later[0].newer.number >= slip);
}

}  // namespace crsm
