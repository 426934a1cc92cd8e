#include "common/fleet/fleet_drawing.hpp"

#include "catch.hpp"
#include "graph/block.hpp"

namespace crsm {
namespace {

constexpr LoopParameters kLoops{true, 40.0};
constexpr std::int64_t kSecond = 1'000'000;

/// A square of 0.3 m, as a robot is seen by others.
void AddRobot(const Pose2& at, std::vector<Wall>& walls) {
  const Point corners[] = {{at.x_m - 0.15, at.y_m - 0.15},
                           {at.x_m + 0.15, at.y_m - 0.15},
                           {at.x_m + 0.15, at.y_m + 0.15},
                           {at.x_m - 0.15, at.y_m + 0.15}};
  for (int i = 0; i < 4; ++i) walls.push_back({corners[i], corners[(i + 1) % 4]});
}

/// Two robots that follow each other through the block, and see each other. Their clocks differ by an hour.
struct Convoy {
  Convoy() : fleet(kLoops, UpdateParameters{}) {
    const std::vector<Wall> block = MakeBlock(3);
    fleet.BeginMap();
    fleet.BeginMap();
    Random random(1);
    for (int i = 0; i < 60; ++i) {
      for (int robot = 0; robot < 2; ++robot) {
        const Pose2 here = PlaceRoundBlock(8.0 + 0.5 * i + 3.0 * robot);
        const Pose2 other = PlaceRoundBlock(8.0 + 0.5 * i + 3.0 * (1 - robot));
        std::vector<Wall> walls = block;
        AddRobot(other, walls);
        Keyframe keyframe;
        keyframe.utime = i * kSecond + (robot == 1 ? 3600 * kSecond : 0);
        keyframe.rays = SeeRays(walls, here, random);
        keyframe.begins = i == 0;
        if (i > 0) keyframe.T_previous_this = Inverse(PlaceRoundBlock(8.0 + 0.5 * (i - 1) + 3.0 * robot)) * here;
        const std::int64_t utime = keyframe.utime;
        fleet.Add(robot, keyframe, {}, {});
        clock.Add(fleet.graph().newest(robot), utime, 10'000 * kSecond + i * kSecond);
      }
    }
    fleet.Solve();
  }

  /// Whether the map has a wall near a place on the way.
  static bool HasWallNear(const ByteMap& map, const Pose2& place) {
    for (double x = -0.3; x <= 0.3; x += 0.05) {
      for (double y = -0.3; y <= 0.3; y += 0.05) {
        if (map.At(map.geometry().CellAt(place.x_m + x, place.y_m + y)) < 100) return true;
      }
    }
    return false;
  }

  /// How many places where a robot was have walls.
  int CountGhosts(const FleetConstants& constants) const {
    FleetDrawing drawing(UpdateParameters{}, constants);
    const int piece = fleet.graph().piece(fleet.graph().newest(0));
    while (!drawing.Draw(fleet, clock, piece, 1, 7)) {
    }
    ByteMap map(drawing.map().geometry().cell_size_m());
    for (std::size_t i = 0; i < drawing.map().num_tiles(); ++i) map.Apply(*drawing.map().TileSince(i, -1));
    int num = 0;
    for (int i = 0; i < 60; ++i) num += HasWallNear(map, fleet.graph().pose({0, {0, i}}));
    return num;
  }

  Fleet fleet;
  FleetClock clock;
};

}  // namespace

TEST_CASE("robots that see each other are no walls of the common map, and walls stay") {
  const Convoy convoy;
  const FleetGraph& graph = convoy.fleet.graph();
  REQUIRE(graph.HangTogether(graph.newest(0), graph.newest(1)));
  CHECK(convoy.CountGhosts({}) == 0);
  FleetConstants see_all;
  see_all.robot_m = 0.0;
  CHECK(convoy.CountGhosts(see_all) > 2);

  FleetDrawing drawing(UpdateParameters{});
  const FleetKeyframeId at{1, {0, 40}};
  const std::size_t num_all = graph.map(1).keyframe(at.id).rays.size();
  const std::size_t num_kept = drawing.WithoutRobots(convoy.fleet, convoy.clock, at).size();
  CHECK(num_kept < num_all);
  CHECK(num_kept > num_all - 20);  // the other robot is 3 m away, and 0.6 m around it are 23 degrees of 2 each
}

TEST_CASE("where a robot was between its keyframes and after them is known by one clock, however wrong its own is") {
  const Convoy convoy;
  const FleetGraph& graph = convoy.fleet.graph();
  const int piece = graph.piece(graph.newest(0));
  const auto At = [&](double time_s, const FleetConstants& constants = {}) {
    return convoy.clock.FindPose(graph, 1, static_cast<std::int64_t>(1e6 * (10'000.0 + time_s)), piece, constants);
  };
  CHECK_FALSE(At(-1.0));
  REQUIRE(At(10.5));
  CHECK(Distance(*At(10.0), graph.pose({1, {0, 10}})) < 1e-9);
  CHECK(std::abs(Distance(*At(10.5), graph.pose({1, {0, 10}})) - 0.25) < 0.01);
  CHECK(Distance(*At(100.0), graph.pose(graph.newest(1))) < 1e-9);  // it is taken to stand there ...
  CHECK_FALSE(At(59.0 + 601.0));                                    // ... but not for ever
  CHECK_FALSE(convoy.clock.FindPose(graph, 1, 10'010 * kSecond, piece + 7));
}

TEST_CASE("pieces of a fleet come by size, and where its trajectories begin is told with the numbers of their pieces") {
  Fleet fleet(kLoops, UpdateParameters{});
  CHECK(SortPieces(fleet.graph()).empty());
  const std::vector<Wall> walls = MakeBlock(2);
  Random random(2);
  for (int robot = 0; robot < 2; ++robot) {
    fleet.BeginMap();
    for (int i = 0; i < 2 + robot; ++i) {
      Keyframe keyframe;
      keyframe.utime = i;
      keyframe.rays = SeeRays(walls, PlaceRoundBlock(5.0 + i), random);
      keyframe.begins = i == 0;
      if (i > 0) keyframe.T_previous_this = {1.0, 0.0, 0.0};
      fleet.Add(robot, keyframe, {}, {});
    }
  }
  const std::vector<int> pieces = SortPieces(fleet.graph());
  CHECK(pieces == std::vector<int>{1, 0});  // the second robot has one keyframe more
  const MapPieces described = DescribePieces(fleet, pieces);
  CHECK(described.num_pieces == 2);
  CHECK(described.pieces[0].keyframes == 3);
  CHECK(described.pieces[0].way_m == Approx(2.0));
  REQUIRE(described.breaks.size() == 1);
  CHECK(described.breaks[0].scan == 2);
  CHECK(described.breaks[0].piece_before == 2);
  CHECK(described.breaks[0].piece == 1);
  CHECK(PlaceLoops(fleet.graph(), 0).empty());
}

}  // namespace crsm
