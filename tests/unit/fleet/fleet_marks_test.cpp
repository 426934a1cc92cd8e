#include "common/fleet/fleet_marks.hpp"

#include <cmath>

#include "catch.hpp"
#include "common/fleet/fleet.hpp"
#include "graph/block.hpp"

namespace crsm {
namespace {

/// Two robots that have driven along the same corridor, and know nothing of each other.
struct TwoRobots {
  TwoRobots() {
    for (const std::uint64_t seed : {1u, 2u}) {
      const int map = fleet.BeginMap();
      for (Keyframe keyframe : MakeKeyframes(MakeBlock(1), DriveRoundBlock(5.0, 9.0), {}, seed)) {
        fleet.Add(map, std::move(keyframe), {}, EarlierFleetSearch{});
      }
    }
  }

  /// The common graph, where the second is seen from the first at that place.
  FleetGraph Join(const Pose2& T_first_second) const {
    FleetGraph joined;
    for (int map = 0; map < 2; ++map) {
      KeyframeGraph& graph = graphs[static_cast<std::size_t>(map)];
      joined.AddMap(graph);
      for (const KeyframeId id : fleet.graph().map(map).ids()) {
        graph.Add(fleet.graph().map(map).keyframe(id));
        joined.AddNewest(map);
      }
    }
    joined.AddLoop({{0, {0, 0}}, {1, {0, 0}}, T_first_second});
    return joined;
  }

  Fleet fleet{{true, 40.0}, UpdateParameters{}};
  mutable std::array<KeyframeGraph, 2> graphs;
};

AnchoredMark At(const std::string& id, int keyframe, Point at, const std::string& name = "") {
  return {{5, id, "victim", name, 1, {0.04, 0.0, 0.01}, false, {}}, {{{0, keyframe}, at}}};
}

}  // namespace

TEST_CASE("places of one id of two robots are two places, which carry the names of their robots") {
  const TwoRobots robots;
  const FleetGraph& graph = robots.fleet.graph();
  FleetMarks marks;
  CHECK(marks.Place(graph, 0).empty());
  marks.Set(0, "robot1", {At("v", 0, {1.0, 0.5}, "in the hall")});
  marks.Set(1, "robot2", {At("v", 0, {2.0, 0.5})});
  const auto placed = marks.Place(graph, 0);
  REQUIRE(placed.size() == 2);
  CHECK(placed[0].id == "robot1/v");
  CHECK(placed[0].name == "robot1: in the hall");
  CHECK(placed[1].id == "robot2/v");
  CHECK(placed[1].name == "robot2");
  CHECK_FALSE(placed[0].floating);
  CHECK(placed[1].floating);  // the maps are not joined
  CHECK(marks.Count() == 2);
  marks.Set(0, "robot1", {});  // removed there
  CHECK(marks.Place(graph, 0).size() == 1);
}

TEST_CASE("the places of a robot move with its map when that is joined with another") {
  const TwoRobots robots;
  FleetMarks marks;
  AnchoredMark zone = At("zone", 0, {0.0, 0.0});
  zone.points.push_back({{0, 3}, {1.0, 0.0}});
  zone.points.push_back({{0, 3}, {1.0, 1.0}});
  marks.Set(1, "robot2", {At("v", 0, {1.0, 0.5}), zone});
  const FleetGraph graph = robots.Join({10.0, -3.0, kPi / 2.0});
  const auto placed = marks.Place(graph, graph.piece({0, {0, 0}}));
  REQUIRE(placed.size() == 2);
  CHECK_FALSE(placed[0].floating);
  CHECK(std::abs(placed[0].points[0].x_m - (10.0 - 0.5)) < 1e-9);
  CHECK(std::abs(placed[0].points[0].y_m - (-3.0 + 1.0)) < 1e-9);
  CHECK(std::abs(placed[0].covariance[0] - 0.01) < 1e-12);  // turned by a quarter
  CHECK(std::abs(placed[0].covariance[2] - 0.04) < 1e-12);
  REQUIRE(placed[1].points.size() == 3);
  const Pose2 corner = graph.pose({1, {0, 3}}) * Pose2{1.0, 1.0, 0.0};
  CHECK(std::abs(placed[1].points[2].x_m - corner.x_m) < 1e-9);
}

TEST_CASE("of one id on two maps of one robot the place on the map that is shown counts, else that of the newer map") {
  const TwoRobots robots;
  const FleetGraph& graph = robots.fleet.graph();
  FleetMarks marks;
  marks.Set(0, "robot1", {At("v", 0, {1.0, 0.5}, "old"), At("w", 0, {1.0, 0.5})});
  marks.Set(1, "robot1", {At("v", 0, {2.0, 0.5}, "new")});
  CHECK(marks.Place(graph, 0).at(0).name == "robot1: old");
  CHECK(marks.Place(graph, 1).at(0).name == "robot1: new");
  CHECK(marks.Place(graph, -1).at(0).name == "robot1: new");
  CHECK(marks.Place(graph, 0).size() == 2);
  CHECK(marks.Count() == 2);
}

TEST_CASE("more places than there is room for are left out, and those at no keyframe do not fit") {
  const TwoRobots robots;
  const FleetGraph& graph = robots.fleet.graph();
  CHECK(FleetMarks::Fits(graph, 0, {At("v", 0, {})}));
  CHECK_FALSE(FleetMarks::Fits(graph, 0, {At("v", 1'000'000, {})}));
  FleetMarks marks;
  std::vector<AnchoredMark> many;
  for (int i = 0; i < 600; ++i) many.push_back(At(std::to_string(i), 0, {}));
  marks.Set(0, "robot1", many);
  marks.Set(1, "robot2", many);
  CHECK(marks.Count() == 1200);
  CHECK(marks.Place(graph, 0).size() == PlacedMark::kMostOnMap);
}

}  // namespace crsm
