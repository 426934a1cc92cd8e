#include "services/map_viewer/fleet_robots.hpp"

#include "catch.hpp"

namespace crsm {
namespace {

using std::chrono::seconds;
using Kind = JoinEvent::Kind;

const FleetRobots::Clock::time_point kStart{seconds(1000)};

fleet_pose_t PoseOf(const std::string& robot, std::vector<std::int32_t> trajectories, bool floating = false) {
  fleet_pose_t pose{};
  pose.robot = robot;
  pose.epoch = 7;
  pose.floating = floating ? 1 : 0;
  pose.heard = 1;
  pose.num_keyframes = 40;
  pose.T_common_map = {1.0, 2.0, 0.5};
  pose.num_trajectories = static_cast<std::int32_t>(trajectories.size());
  pose.trajectories = std::move(trajectories);
  return pose;
}

ScanMatch KeyframeOf(int trajectory, double x_m, bool floating = false) {
  ScanMatch match;
  match.trajectory = trajectory;
  match.T_map_laser = {x_m, -1.0, 0.0};
  match.floating = floating;
  return match;
}

/// Two robots, of which the second one floats; the common map has a keyframe of each.
struct TwoRobots : FleetRobots {
  TwoRobots() {
    Hear(PoseOf("robot1/", {0}), kStart);
    Hear(PoseOf("robot2/", {1}, true), kStart);
    ShowKeyframes({KeyframeOf(0, 3.0), KeyframeOf(1, 4.0, true)});
  }
  void ShowKeyframes(const std::vector<ScanMatch>& keyframes) {
    Begin();
    for (const ScanMatch& keyframe : keyframes) Add(keyframe);
    Show();
  }
};

}  // namespace

TEST_CASE("a robot of a fleet is where its newest keyframe is on the map that is whole, on its newest trajectory") {
  TwoRobots fleet;
  fleet.Hear(PoseOf("robot1/", {0, 2}), kStart);
  fleet.Begin();
  fleet.Add(KeyframeOf(0, 5.0));
  const auto before = fleet.Describe(kStart)["robots"];
  CHECK(before[0]["newest"] == nlohmann::json{3.0, -1.0, 0.0});  // the new map is not whole yet
  CHECK(before[1]["newest"] == nlohmann::json{4.0, -1.0, 0.0});
  CHECK((before[0]["floating"] == false && before[1]["floating"] == true));
  fleet.Add(KeyframeOf(2, 6.0));
  fleet.Add(KeyframeOf(2, 7.0));
  fleet.Show();
  const auto after = fleet.Describe(kStart)["robots"];
  CHECK(after[0]["newest"] == nlohmann::json{7.0, -1.0, 0.0});
  CHECK_FALSE(after[1].contains("newest"));
  CHECK(after[0]["trajectories"] == nlohmann::json{0, 2});
  CHECK(after[0]["epoch"] == "7");  // as text: JavaScript's numbers have 53 bits
}

TEST_CASE("a robot of which nothing is told for ten seconds is silent, as one that fleet_mapper does not hear") {
  TwoRobots fleet;
  fleet_pose_t unheard = PoseOf("robot2/", {1});
  unheard.heard = 0;
  fleet.Hear(unheard, kStart);
  const auto HeardAt = [&](int second) {
    const auto robots = fleet.Describe(kStart + seconds(second))["robots"];
    return std::pair(robots[0]["heard"].get<bool>(), robots[1]["heard"].get<bool>());
  };
  CHECK(HeardAt(9) == std::pair(true, false));
  CHECK(HeardAt(10) == std::pair(false, false));
}

TEST_CASE("a join is told by the robot that floated before, and where it is on the common map") {
  TwoRobots fleet;
  fleet.ShowKeyframes({KeyframeOf(0, 3.0), KeyframeOf(1, 8.25)});
  CHECK(fleet.DescribeNews({{Kind::kJoined, 1, 0}}) == std::vector<std::string>{"robot2/ joined at 8.2, -1.0"});
  const auto joins = fleet.Describe(kStart)["joins"];
  CHECK(joins["number"] == 1);
  CHECK(joins["places"] == nlohmann::json{{8.25, -1.0}});

  TwoRobots other;  // what the second robot has drawn was shown, because it was larger
  other.ShowKeyframes({KeyframeOf(0, 3.0, true), KeyframeOf(1, 4.0)});
  other.ShowKeyframes({KeyframeOf(0, 5.0), KeyframeOf(1, 4.0)});
  CHECK(other.DescribeNews({{Kind::kJoined, 1, 0}}) == std::vector<std::string>{"robot1/ joined at 5.0, -1.0"});
}

TEST_CASE("other news have the names of robots, and trajectories of nobody their numbers") {
  TwoRobots fleet;
  CHECK(fleet.DescribeNews(
            {{Kind::kFloats, 1}, {Kind::kRejected, 1}, {Kind::kJoinedFloating, 9, 1}, {Kind::kJoined, 9, 8}}) ==
        std::vector<std::string>{"floating: not joined to the map yet (robot2/)",
                                 "a join was rejected: robot2/ is a part of its own again",
                                 "joined: trajectory 9 with robot2/, both float", "joined: trajectory 9 with the map"});
  CHECK(fleet.DescribeNews({}).empty());
  CHECK(fleet.Describe(kStart)["joins"]["number"] == 0);
}

TEST_CASE("robots of a fleet have an order that does not depend on who was heard first, and there are 64 at most") {
  FleetRobots fleet;
  CHECK(fleet.empty());
  CHECK(fleet.Describe(kStart)["robots"].empty());
  for (int i = 64; i > 0; --i) CHECK(fleet.Hear(PoseOf("robot" + std::to_string(i) + "/", {}), kStart));
  CHECK_FALSE(fleet.Hear(PoseOf("robot65/", {}), kStart));
  CHECK(fleet.Hear(PoseOf("robot2/", {5}), kStart));
  const auto robots = fleet.Describe(kStart)["robots"];
  REQUIRE(robots.size() == 64);
  CHECK((robots[1]["name"] == "robot2/" && robots[9]["name"] == "robot10/"));
  CHECK_FALSE(FleetRobots().Hear(PoseOf(std::string(64, 'x'), {}), kStart));
}

}  // namespace crsm
