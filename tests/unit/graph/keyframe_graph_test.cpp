#include "common/graph/keyframe_graph.hpp"

#include <cmath>
#include <map>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

Keyframe MakeKeyframe(const Pose2& T_previous_this, const std::optional<Tie>& tie = std::nullopt) {
  Keyframe keyframe;
  keyframe.T_previous_this = T_previous_this;
  keyframe.tie = tie;
  return keyframe;
}

/// Straight on, `num` keyframes a metre apart.
KeyframeGraph DriveStraight(int num) {
  KeyframeGraph graph;
  for (int i = 0; i < num; ++i) graph.Add(MakeKeyframe({1.0, 0.0, 0.0}));
  return graph;
}

/// Where the k-th keyframe truly is: round a square of 20 m, a metre a step; step 80 is the start again.
std::vector<Pose2> SquareRound(int num) {
  std::vector<Pose2> poses{{}};
  for (int i = 1; i < num; ++i) poses.push_back(poses.back() * Pose2{1.0, 0.0, i % 20 == 0 ? kPi / 2 : 0.0});
  return poses;
}

/// A drive whose every metre is matched with an error.
KeyframeGraph DriveDrifting(const std::vector<Pose2>& truth, const Pose2& error, std::uint64_t seed = 1) {
  Random random(seed);
  KeyframeGraph graph;
  graph.Add(MakeKeyframe({}));
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const Pose2 noise{0.003 * random.Gaussian(), 0.003 * random.Gaussian(), 0.0005 * random.Gaussian()};
    graph.Add(MakeKeyframe(Inverse(truth[i - 1]) * truth[i] * error * noise));
  }
  return graph;
}

Loop TrueLoop(const std::vector<Pose2>& truth, int older, int newer, const Pose2& error = {}) {
  const auto At = [&](int i) { return truth[static_cast<std::size_t>(i)]; };
  return {older, newer, Inverse(At(older)) * At(newer) * error};
}

double LargestDistance_m(const std::vector<Pose2>& one, const std::vector<Pose2>& other) {
  double largest_m = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    largest_m = std::max(largest_m, std::hypot(one[i].x_m - other[i].x_m, one[i].y_m - other[i].y_m));
  }
  return largest_m;
}

std::map<int, double> Within(const KeyframeGraph& graph, int from, double reach_m) {
  const auto found = graph.FindWithin(from, reach_m);
  return {found.begin(), found.end()};
}

}  // namespace

TEST_CASE("the poses of keyframes follow from the motions between them") {
  KeyframeGraph graph;
  CHECK(graph.Add(MakeKeyframe({5.0, 5.0, 1.0})) == 0);  // of no meaning in the first
  CHECK(graph.Add(MakeKeyframe({3.0, 4.0, kPi / 2})) == 1);
  CHECK(graph.Add(MakeKeyframe({1.0, 0.0, 0.0})) == 2);
  CHECK(graph.size() == 3);
  CHECK(graph.pose(0) == Pose2{});
  CheckPose(graph.pose(1), {3.0, 4.0, kPi / 2}, 1e-9);
  CheckPose(graph.pose(2), {3.0, 5.0, kPi / 2}, 1e-9);
  CHECK(graph.path_m(0) == 0.0);
  CHECK(graph.path_m(1) == Approx(5.0));
  CHECK(graph.path_m(2) == Approx(6.0));
  CheckPose(graph.Motion(1, 2), {1.0, 0.0, 0.0}, 1e-9);
  CheckPose(graph.Motion(2, 0) * graph.Motion(0, 2), {}, 1e-9);
  CHECK(graph.Motion(1, 1) == Pose2{});
}

TEST_CASE("a keyframe is found by its way along the path") {
  const KeyframeGraph graph = DriveStraight(5);
  CHECK(graph.FindByPath(-1.0) == 0);
  CHECK(graph.FindByPath(2.0) == 2);
  CHECK(graph.FindByPath(2.1) == 3);
  CHECK(graph.FindByPath(4.0) == 4);
  CHECK(graph.FindByPath(100.0) == 4);
}

TEST_CASE("what is near is near along motions, ties and loops, by the shortest way") {
  KeyframeGraph graph = DriveStraight(10);
  CHECK(Within(graph, 4, 0.0) == std::map<int, double>{{4, 0.0}});
  CHECK(Within(graph, 4, 2.0) == std::map<int, double>{{2, 2.0}, {3, 1.0}, {4, 0.0}, {5, 1.0}, {6, 2.0}});

  SECTION("a tie leads to the keyframe it was matched at, until it is dropped") {
    const int tied = graph.Add(MakeKeyframe({1.0, 0.0, 0.0}, Tie{2, {0.3, 0.4, 0.0}}));
    CHECK(Within(graph, tied, 1.6) == std::map<int, double>{{1, 1.5}, {2, 0.5}, {3, 1.5}, {9, 1.0}, {10, 0.0}});
    graph.DropTies(tied + 1);
    CHECK(Within(graph, tied, 1.0).count(2) == 1);
    graph.DropTies(tied);
    CHECK(Within(graph, tied, 1.6) == std::map<int, double>{{9, 1.0}, {10, 0.0}});
    CHECK(graph.keyframe(tied).tie_wrong);
  }
  SECTION("so does a loop, until it is dropped") {
    const Loop loop{1, 9, {0.0, 0.5, 3.0}};
    graph.AddLoop(loop);
    CHECK(Within(graph, 9, 1.5) == std::map<int, double>{{0, 1.5}, {1, 0.5}, {2, 1.5}, {8, 1.0}, {9, 0.0}});
    graph.DropLoop({1, 9, {0.0, 0.6, 3.0}});  // another one, which is not there
    CHECK(graph.loops() == std::vector<Loop>{loop});
    graph.DropLoop(loop);
    CHECK(graph.loops().empty());
    CHECK(Within(graph, 9, 1.5) == std::map<int, double>{{8, 1.0}, {9, 0.0}});
  }
  SECTION("a loop between keyframes that are tied is dropped without the tie") {
    const int tied = graph.Add(MakeKeyframe({1.0, 0.0, 0.0}, Tie{2, {0.5, 0.0, 0.0}}));
    const Loop loop{2, tied, {0.25, 0.0, 0.0}};
    graph.AddLoop(loop);
    CHECK(Within(graph, tied, 1.0)[2] == 0.25);
    graph.DropLoop(loop);
    CHECK(Within(graph, tied, 1.0)[2] == 0.5);
  }
}

TEST_CASE("a loop puts a square right that has drifted, and motions stay as they were matched") {
  const std::vector<Pose2> truth = SquareRound(83);
  KeyframeGraph graph = DriveDrifting(truth, {0.0, 0.0, 0.001});
  const double before_m = LargestDistance_m(graph.poses(), truth);
  REQUIRE(before_m > 0.7);
  const Pose2 motion = graph.Motion(3, 77);
  const Pose2 back = graph.Motion(77, 3);
  graph.AddLoop(TrueLoop(truth, 0, 80));
  graph.AddLoop(TrueLoop(truth, 2, 82));
  CHECK(graph.Optimise().empty());
  CHECK(graph.loops().size() == 2);
  CHECK(LargestDistance_m(graph.poses(), truth) < 0.5 * before_m);
  // The loops are known to 3 cm and 0.005 rad: three deviations.
  CheckPose(Inverse(graph.pose(0)) * graph.pose(80), TrueLoop(truth, 0, 80).T_older_newer, 0.1);
  CHECK(graph.Motion(3, 77) == motion);
  CHECK(graph.Motion(77, 3) == back);
  CHECK(graph.path_m(82) == Approx(82.0).margin(0.2));
}

TEST_CASE("a loop that all others contradict is taken out") {
  const std::vector<Pose2> truth = SquareRound(83);
  KeyframeGraph graph = DriveDrifting(truth, {0.0, 0.0, 0.0005});
  const Loop wrong = TrueLoop(truth, 10, 50, {4.0, 0.0, 0.0});  // as far as from one door to the next
  graph.AddLoop(wrong);
  for (const int i : {0, 1, 2}) graph.AddLoop(TrueLoop(truth, i, 80 + i));
  CHECK(graph.Optimise() == std::vector<Loop>{wrong});
  CHECK(graph.loops().size() == 3);
  CHECK(Within(graph, 10, 30.0).count(50) == 0);
  CHECK(LargestDistance_m(graph.poses(), truth) < 0.3);
  CHECK(graph.Optimise().empty());
}

TEST_CASE("a tie holds a keyframe at the place where it was matched") {
  const std::vector<Pose2> truth = SquareRound(81);
  KeyframeGraph graph = DriveDrifting(truth, {0.0, 0.0, 0.001});
  Keyframe tied = MakeKeyframe(Inverse(truth[0]) * truth[1], Tie{1, {}});
  tied.T_previous_this = Inverse(graph.pose(80)) * graph.pose(1);  // as matched: right where it was
  graph.Add(tied);
  CHECK(graph.MakePoseGraph().edges().size() == 82);  // 81 motions and the tie
  graph.Optimise();
  CheckPose(Inverse(graph.pose(1)) * graph.pose(81), {}, 0.02);
}

TEST_CASE("where a corridor left the position open, and where scans were lost, a motion gives way") {
  const auto BendAt = [](const Keyframe& second) {
    KeyframeGraph graph;
    graph.Add(MakeKeyframe({}));
    graph.Add(second);
    graph.Add(MakeKeyframe({1.0, 0.0, 0.0}));
    graph.AddLoop({0, 2, {2.0, 0.1, 0.0}});
    graph.Optimise();
    return graph.pose(1).y_m;
  };
  Keyframe plain = MakeKeyframe({1.0, 0.0, 0.0});
  Keyframe open = plain;
  open.open_axis = Eigen::Vector2d(0.0, 1.0);
  Keyframe turned = MakeKeyframe({1.0, 0.0, kPi / 2});
  turned.open_axis = Eigen::Vector2d(1.0, 0.0);  // its own x axis is the first one's y axis
  Keyframe after_lost = plain;
  after_lost.after_lost = true;
  CHECK(BendAt(open) > 1.5 * BendAt(plain));
  CHECK(BendAt(after_lost) > 1.5 * BendAt(plain));
  KeyframeGraph graph;
  graph.Add(MakeKeyframe({}));
  graph.Add(turned);
  const Eigen::Matrix3d w = graph.MakePoseGraph().edges()[0].sqrt_information;
  const Eigen::Matrix3d information = w.transpose() * w;
  CHECK(information(0, 0) == Approx(1.0 / (0.01 * 0.01)));  // across the axis, as everywhere
  CHECK(information(1, 1) == Approx(1.0 / (0.05 * 0.05)));  // along it
}

TEST_CASE("what another graph has learned is taken over, and later keyframes follow by their motions") {
  const std::vector<Pose2> truth = SquareRound(100);
  KeyframeGraph robot = DriveDrifting(truth, {0.0, 0.0, 0.001});
  KeyframeGraph other = DriveDrifting({truth.begin(), truth.begin() + 90}, {0.0, 0.0, 0.001});
  GraphUpdate update;
  update.keyframe = 89;
  update.closed = {TrueLoop(truth, 0, 80), TrueLoop(truth, 5, 85)};
  for (const Loop& loop : update.closed) other.AddLoop(loop);
  other.Optimise();
  update.poses = other.poses();
  const KeyframeGraph before = robot;
  robot.Apply(update);
  CHECK(robot.loops() == update.closed);
  for (int i = 0; i < 90; ++i) REQUIRE(robot.pose(i) == other.pose(i));
  REQUIRE(std::hypot(robot.pose(99).x_m - before.pose(99).x_m, robot.pose(99).y_m - before.pose(99).y_m) > 0.3);
  for (int i = 90; i < 100; ++i) {
    CheckPose(Inverse(robot.pose(89)) * robot.pose(i), Inverse(before.pose(89)) * before.pose(i), 1e-9);
  }
}

TEST_CASE("what an update takes out is gone, and an update without poses moves nothing") {
  KeyframeGraph graph = DriveStraight(10);
  graph.Add(MakeKeyframe({1.0, 0.0, 0.0}, Tie{2, {}}));
  const std::vector<Pose2> poses = graph.poses();
  const Loop one{1, 9, {}};
  const Loop two{2, 8, {}};
  graph.AddLoop(one);
  GraphUpdate update;
  update.closed = {two};
  update.taken_out = {one};
  update.ties_wrong_from = 3;
  graph.Apply(update);
  CHECK(graph.loops() == std::vector<Loop>{two});
  CHECK(graph.keyframe(10).tie_wrong);
  CHECK(graph.poses() == poses);
}

/// Two trajectories straight on: ten keyframes, and ten that begin somewhere else.
KeyframeGraph DriveBroken() {
  KeyframeGraph graph = DriveStraight(10);
  for (int i = 0; i < 10; ++i) {
    Keyframe keyframe = MakeKeyframe(i == 0 ? Pose2{5.0, 5.0, 1.0} : Pose2{1.0, 0.0, 0.0});
    keyframe.begins = i == 0;
    graph.Add(std::move(keyframe));
  }
  return graph;
}

TEST_CASE("a keyframe that begins a trajectory hangs on nothing that came before it") {
  const KeyframeGraph graph = DriveBroken();
  CHECK(graph.num_trajectories() == 2);
  CHECK(graph.trajectory(9) == 0);
  CHECK(graph.trajectory(10) == 1);
  CHECK(graph.FirstOf(1) == 10);
  CHECK(graph.LastOf(0) == 9);
  CHECK(graph.LastOf(1) == 19);
  CHECK_FALSE(graph.HangTogether(9, 10));
  CHECK_FALSE(graph.is_one_component());
  CHECK(graph.path_m(10) - graph.path_m(9) == kBreak_m);
  const auto near = Within(graph, 12, 1000.0);
  CHECK(near.size() == 10);
  CHECK(near.begin()->first == 10);
}

TEST_CASE("a loop across joins two trajectories: the younger moves; without the loop they fall apart again") {
  KeyframeGraph graph = DriveBroken();
  const Loop loop{3, 15, {0.0, 1.0, 0.25}};
  const std::vector<Pose2> before = graph.poses();
  graph.Join(loop);
  graph.AddLoop(loop);
  for (std::size_t i = 0; i < 10; ++i) CHECK(graph.poses()[i] == before[i]);
  CheckPose(Inverse(graph.pose(3)) * graph.pose(15), loop.T_older_newer, 1e-9);
  CheckPose(Inverse(graph.pose(10)) * graph.pose(19), Inverse(before[10]) * before[19], 1e-9);
  CHECK(graph.HangTogether(0, 19));
  CHECK(graph.is_one_component());
  CHECK(graph.FindComponents({}) == std::vector<int>{0, 1});
  CHECK(graph.FindComponents({loop}) == std::vector<int>{0, 0});
  CHECK(Within(graph, 12, 1000.0).size() == 20);
  graph.DropLoop(loop);
  CHECK_FALSE(graph.HangTogether(0, 19));
  CHECK(Within(graph, 12, 1000.0).size() == 10);
}

TEST_CASE("what is learned of one component leaves the other where it is") {
  KeyframeGraph graph = DriveBroken();
  graph.AddLoop({10, 19, {8.9, 0.0, 0.0}});  // 0.1 m shorter than it was matched
  const std::vector<Pose2> before = graph.poses();
  CHECK(graph.Optimise().empty());
  for (int i = 0; i < 10; ++i) CheckPose(graph.pose(i), before[static_cast<std::size_t>(i)], 1e-6);
  CHECK(Length(Inverse(graph.pose(10)) * graph.pose(19)) < 8.99);
}

TEST_CASE("the younger component moves, be it that of the older keyframe") {
  KeyframeGraph graph = DriveBroken();
  for (int i = 0; i < 5; ++i) {  // a third trajectory, which is joined with the first
    Keyframe keyframe = MakeKeyframe(i == 0 ? Pose2{-3.0, 2.0, 0.5} : Pose2{1.0, 0.0, 0.0});
    keyframe.begins = i == 0;
    graph.Add(std::move(keyframe));
  }
  const Loop with_first{2, 21, {0.5, 0.0, 0.1}};
  graph.Join(with_first);
  graph.AddLoop(with_first);
  const std::vector<Pose2> before = graph.poses();
  const Loop with_second{12, 23, {0.0, 1.0, -0.5}};
  graph.Join(with_second);
  for (std::size_t i = 0; i < 10; ++i) CHECK(graph.poses()[i] == before[i]);
  for (std::size_t i = 20; i < 25; ++i) CHECK(graph.poses()[i] == before[i]);
  CheckPose(Inverse(graph.pose(12)) * graph.pose(23), with_second.T_older_newer, 1e-9);
}

}  // namespace crsm
