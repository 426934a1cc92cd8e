#include "common/fleet/fleet.hpp"

#include "catch.hpp"
#include "graph/block.hpp"

namespace crsm {
namespace {

constexpr LoopParameters kLoops{true, 40.0};

/// A robot that drives through the block, and maps it for itself.
struct Robot {
  std::vector<Pose2> places;        ///< where it truly was
  std::vector<Keyframe> keyframes;  ///< what it made of that
};

Robot Drive(const std::vector<Wall>& walls, double from_m, double to_m, std::uint64_t seed) {
  Robot robot{DriveRoundBlock(from_m, to_m), {}};
  robot.keyframes = MakeKeyframes(walls, robot.places, {0.002, 0.0, 0.0004}, seed);
  return robot;
}

/// One fleet's keyframes, in turn.
struct Course {
  explicit Course(std::vector<Robot> all) : robots(std::move(all)) {}

  /// earlier: what was found in another run, by the order of keyframes.
  void Run(Fleet& fleet, const std::vector<std::optional<FleetFinding>>* earlier = nullptr) {
    std::size_t longest = 0;
    for (const Robot& robot : robots) {
      fleet.BeginMap();
      longest = std::max(longest, robot.keyframes.size());
    }
    for (std::size_t i = 0; i < longest; ++i) {
      for (std::size_t k = 0; k < robots.size(); ++k) {
        if (i >= robots[k].keyframes.size()) continue;
        Keyframe keyframe = robots[k].keyframes[i];
        keyframe.begins = i == 0;
        std::optional<EarlierFleetSearch> search;
        if (earlier) search = EarlierFleetSearch{(*earlier)[found.size()]};
        found.push_back(fleet.Add(static_cast<int>(k), keyframe, {}, search));
      }
    }
    fleet.Solve();
  }

  /// The largest error of a map's keyframes in the common frame, laid on the truth at the first keyframe of map 0.
  double WorstError_m(const Fleet& fleet, int map) const {
    double worst_m = 0.0;
    const Robot& robot = robots[static_cast<std::size_t>(map)];
    for (std::size_t i = 0; i < robot.places.size(); ++i) {
      const Pose2 truth = Inverse(robots[0].places[0]) * robot.places[i];
      worst_m = std::max(worst_m, Distance(truth, fleet.graph().pose({map, {0, static_cast<int>(i)}})));
    }
    return worst_m;
  }

  std::vector<Robot> robots;
  std::vector<std::optional<FleetFinding>> found;
};

bool AreJoined(const Fleet& fleet, int a, int b) {
  return fleet.graph().HangTogether(fleet.graph().newest(a), fleet.graph().newest(b));
}

}  // namespace

TEST_CASE("two robots that start elsewhere are joined where their ways meet, and their frame is that of the first") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    const std::vector<Wall> walls = MakeBlock(seed);
    Course course({Drive(walls, 5.0, 45.0, seed), Drive(walls, 70.0, 20.0, 10 + seed)});
    Fleet fleet(kLoops, UpdateParameters{});
    course.Run(fleet);
    REQUIRE(AreJoined(fleet, 0, 1));
    CHECK(fleet.graph().loops().size() >= 2);
    CHECK(fleet.graph().rejected().empty());
    CHECK(fleet.graph().pose({0, {0, 0}}) == Pose2{});
    // 40 m at 2 mm and 0.4 mrad a metre drift by 0.4 m; what lies over the loops is no worse than both.
    CHECK(course.WorstError_m(fleet, 0) < 0.5);
    CHECK(course.WorstError_m(fleet, 1) < 0.8);
    CHECK(fleet.graph().covariance(0) != PoseCovariance{});  // the newest keyframe, as seen from the first
    const Pose2 frame = fleet.graph().FindFrame(1);
    const auto error = EstimateMapError(fleet.graph().CollectMotions(fleet.graph().piece({0, {0, 0}})));
    REQUIRE(error);
    const double worst_m = std::max(course.WorstError_m(fleet, 0), course.WorstError_m(fleet, 1));
    CHECK(error->most_m > 0.5 * worst_m);  // laid on the truth as a whole, and not at one keyframe, it is less off
    CHECK(error->most_m < 20.0 * worst_m);
    CHECK(Distance(frame * fleet.graph().map(1).pose({0, 100}), fleet.graph().pose({1, {0, 100}})) < 0.2);
  }
}

TEST_CASE("robots in different buildings are never joined, and each keeps its own frame") {
  // Other corridors: 4.2 m and 2.4 m wide.
  Robot elsewhere{DriveRoundBlock(70.0, 10.0), {}};
  std::vector<Wall> walls = MakeBlock(5);
  const auto Stretch = [](auto& at) {
    at.x_m *= 1.4;
    at.y_m *= 0.8;
  };
  for (Wall& wall : walls) {
    Stretch(wall.from);
    Stretch(wall.to);
  }
  std::ranges::for_each(elsewhere.places, Stretch);
  elsewhere.keyframes = MakeKeyframes(walls, elsewhere.places, {0.002, 0.0, 0.0004}, 2);
  Course course({Drive(MakeBlock(1), 5.0, 60.0, 1), elsewhere});
  Fleet fleet(kLoops, UpdateParameters{});
  course.Run(fleet);
  CHECK_FALSE(AreJoined(fleet, 0, 1));
  CHECK(fleet.graph().loops().empty());
  CHECK(fleet.num_searched() > 20);
  CHECK(Distance(fleet.graph().FindFrame(1), Pose2{}) < 1e-9);
  for (int i = 0; i < fleet.graph().map(1).size(0); ++i) {
    REQUIRE(fleet.graph().pose({1, {0, i}}) == fleet.graph().map(1).pose({0, i}));
  }
}

TEST_CASE("what was found before is not searched again, and gives the same common map, to the last bit") {
  const std::vector<Wall> walls = MakeBlock(2);
  Course course({Drive(walls, 5.0, 45.0, 2), Drive(walls, 70.0, 20.0, 12)});
  Course again = course;
  Fleet fleet(kLoops, UpdateParameters{});
  course.Run(fleet);
  REQUIRE(AreJoined(fleet, 0, 1));
  Fleet told(kLoops, UpdateParameters{});
  again.Run(told, &course.found);
  CHECK(told.num_searched() == 0);
  CHECK(told.graph().loops() == fleet.graph().loops());
  for (const FleetKeyframeId& at : fleet.keyframes()) REQUIRE(told.graph().pose(at) == fleet.graph().pose(at));
}

}  // namespace crsm
