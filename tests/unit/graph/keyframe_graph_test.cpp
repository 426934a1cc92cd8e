#include "common/graph/keyframe_graph.hpp"

#include <cmath>
#include <map>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/math/random.hpp"
#include "graph/nth.hpp"

namespace crsm {
namespace {

Keyframe MakeKeyframe(const Pose2& T_previous_this,
                      const std::optional<ProximityConstraint>& constraint = std::nullopt) {
  Keyframe keyframe;
  keyframe.T_previous_this = T_previous_this;
  keyframe.constraint = constraint;
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
  return {Nth(older), Nth(newer), Inverse(At(older)) * At(newer) * error};
}

double LargestDistance_m(const KeyframePoses& poses, const std::vector<Pose2>& other) {
  REQUIRE(poses.size() == 1);
  const std::vector<Pose2>& one = poses[0];
  double largest_m = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    largest_m = std::max(largest_m, std::hypot(one[i].x_m - other[i].x_m, one[i].y_m - other[i].y_m));
  }
  return largest_m;
}

std::map<KeyframeId, double> Within(const KeyframeGraph& graph, KeyframeId from, double reach_m) {
  const auto found = graph.FindWithin(from, reach_m);
  return {found.begin(), found.end()};
}

/// By their numbers on the first trajectory.
std::map<int, double> Within(const KeyframeGraph& graph, int from, double reach_m) {
  std::map<int, double> numbers;
  for (const auto& [id, way_m] : Within(graph, Nth(from), reach_m)) {
    REQUIRE(id.trajectory == 0);
    numbers[id.number] = way_m;
  }
  return numbers;
}

}  // namespace

TEST_CASE("the poses of keyframes follow from the motions between them") {
  KeyframeGraph graph;
  CHECK(graph.Add(MakeKeyframe({5.0, 5.0, 1.0})) == Nth(0));  // of no meaning in the first
  CHECK(graph.Add(MakeKeyframe({3.0, 4.0, kPi / 2})) == Nth(1));
  CHECK(graph.Add(MakeKeyframe({1.0, 0.0, 0.0})) == Nth(2));
  CHECK(graph.size() == 3);
  CHECK(graph.pose(Nth(0)) == Pose2{});
  CheckPose(graph.pose(Nth(1)), {3.0, 4.0, kPi / 2}, 1e-9);
  CheckPose(graph.pose(Nth(2)), {3.0, 5.0, kPi / 2}, 1e-9);
  CHECK(graph.path_m(Nth(0)) == 0.0);
  CHECK(graph.path_m(Nth(1)) == Approx(5.0));
  CHECK(graph.path_m(Nth(2)) == Approx(6.0));
  CheckPose(graph.Motion(Nth(1), Nth(2)), {1.0, 0.0, 0.0}, 1e-9);
  CheckPose(graph.Motion(Nth(2), Nth(0)) * graph.Motion(Nth(0), Nth(2)), {}, 1e-9);
  CHECK(graph.Motion(Nth(1), Nth(1)) == Pose2{});
}

TEST_CASE("a keyframe is found by its way along the path") {
  const KeyframeGraph graph = DriveStraight(5);
  CHECK(graph.FindByPath(0, -1.0) == Nth(0));
  CHECK(graph.FindByPath(0, 2.0) == Nth(2));
  CHECK(graph.FindByPath(0, 2.1) == Nth(3));
  CHECK(graph.FindByPath(0, 4.0) == Nth(4));
  CHECK(graph.FindByPath(0, 100.0) == Nth(4));
}

TEST_CASE("what is near is near along motions, ties and loops, by the shortest way") {
  KeyframeGraph graph = DriveStraight(10);
  CHECK(Within(graph, 4, 0.0) == std::map<int, double>{{4, 0.0}});
  CHECK(Within(graph, 4, 2.0) == std::map<int, double>{{2, 2.0}, {3, 1.0}, {4, 0.0}, {5, 1.0}, {6, 2.0}});

  SECTION("a constraint leads to the keyframe it was matched at, until it is dropped") {
    const KeyframeId constrained =
        graph.Add(MakeKeyframe({1.0, 0.0, 0.0}, ProximityConstraint{Nth(2), {0.3, 0.4, 0.0}}));
    CHECK(Within(graph, constrained.number, 1.6) ==
          std::map<int, double>{{1, 1.5}, {2, 0.5}, {3, 1.5}, {9, 1.0}, {10, 0.0}});
    graph.DropConstraints({0, constrained.number + 1});
    CHECK(Within(graph, constrained.number, 1.0).count(2) == 1);
    graph.DropConstraints(constrained);
    CHECK(Within(graph, constrained.number, 1.6) == std::map<int, double>{{9, 1.0}, {10, 0.0}});
    CHECK(graph.keyframe(constrained).constraint_wrong);
  }
  SECTION("so does a loop, until it is dropped") {
    const Loop loop{Nth(1), Nth(9), {0.0, 0.5, 3.0}};
    graph.AddLoop(loop);
    CHECK(Within(graph, 9, 1.5) == std::map<int, double>{{0, 1.5}, {1, 0.5}, {2, 1.5}, {8, 1.0}, {9, 0.0}});
    graph.DropLoop({Nth(1), Nth(9), {0.0, 0.6, 3.0}});  // another one, which is not there
    CHECK(graph.loops() == std::vector<Loop>{loop});
    graph.DropLoop(loop);
    CHECK(graph.loops().empty());
    CHECK(Within(graph, 9, 1.5) == std::map<int, double>{{8, 1.0}, {9, 0.0}});
  }
  SECTION("a loop between keyframes with a constraint is dropped without the constraint") {
    const KeyframeId constrained =
        graph.Add(MakeKeyframe({1.0, 0.0, 0.0}, ProximityConstraint{Nth(2), {0.5, 0.0, 0.0}}));
    const Loop loop{Nth(2), constrained, {0.25, 0.0, 0.0}};
    graph.AddLoop(loop);
    CHECK(Within(graph, constrained.number, 1.0)[2] == 0.25);
    graph.DropLoop(loop);
    CHECK(Within(graph, constrained.number, 1.0)[2] == 0.5);
  }
}

TEST_CASE("a loop puts a square right that has drifted, and motions stay as they were matched") {
  const std::vector<Pose2> truth = SquareRound(83);
  KeyframeGraph graph = DriveDrifting(truth, {0.0, 0.0, 0.001});
  const double before_m = LargestDistance_m(graph.poses(), truth);
  REQUIRE(before_m > 0.7);
  const Pose2 motion = graph.Motion(Nth(3), Nth(77));
  const Pose2 back = graph.Motion(Nth(77), Nth(3));
  graph.AddLoop(TrueLoop(truth, 0, 80));
  graph.AddLoop(TrueLoop(truth, 2, 82));
  CHECK(graph.Optimise().empty());
  CHECK(graph.loops().size() == 2);
  CHECK(LargestDistance_m(graph.poses(), truth) < 0.5 * before_m);
  // The loops are known to 3 cm and 0.005 rad: three deviations.
  CheckPose(Inverse(graph.pose(Nth(0))) * graph.pose(Nth(80)), TrueLoop(truth, 0, 80).T_older_newer, 0.1);
  CHECK(graph.Motion(Nth(3), Nth(77)) == motion);
  CHECK(graph.Motion(Nth(77), Nth(3)) == back);
  CHECK(graph.path_m(Nth(82)) == Approx(82.0).margin(0.2));
}

TEST_CASE("a loop that all others contradict is rejected") {
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

TEST_CASE("a constraint holds a keyframe at the place where it was matched") {
  const std::vector<Pose2> truth = SquareRound(81);
  KeyframeGraph graph = DriveDrifting(truth, {0.0, 0.0, 0.001});
  Keyframe constrained = MakeKeyframe(Inverse(truth[0]) * truth[1], ProximityConstraint{Nth(1), {}});
  constrained.T_previous_this = Inverse(graph.pose(Nth(80))) * graph.pose(Nth(1));  // as matched: right where it was
  graph.Add(constrained);
  CHECK(graph.MakePoseGraph().edges().size() == 82);  // 81 motions and the constraint
  graph.Optimise();
  CheckPose(Inverse(graph.pose(Nth(1))) * graph.pose(Nth(81)), {}, 0.02);
}

TEST_CASE("where a corridor left the position open, and where scans were lost, a motion gives way") {
  const auto BendAt = [](const Keyframe& second) {
    KeyframeGraph graph;
    graph.Add(MakeKeyframe({}));
    graph.Add(second);
    graph.Add(MakeKeyframe({1.0, 0.0, 0.0}));
    graph.AddLoop({Nth(0), Nth(2), {2.0, 0.1, 0.0}});
    graph.Optimise();
    return graph.pose(Nth(1)).y_m;
  };
  Keyframe plain = MakeKeyframe({1.0, 0.0, 0.0});
  Keyframe open = plain;
  open.degenerate_axis = Eigen::Vector2d(0.0, 1.0);
  Keyframe turned = MakeKeyframe({1.0, 0.0, kPi / 2});
  turned.degenerate_axis = Eigen::Vector2d(1.0, 0.0);  // its own x axis is the first one's y axis
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
  update.keyframe = Nth(89);
  update.closed = {TrueLoop(truth, 0, 80), TrueLoop(truth, 5, 85)};
  for (const Loop& loop : update.closed) other.AddLoop(loop);
  other.Optimise();
  update.moved = {{Nth(0), other.poses()[0]}};
  const KeyframeGraph before = robot;
  robot.Apply(update);
  CHECK(robot.loops() == update.closed);
  for (int i = 0; i < 90; ++i) REQUIRE(robot.pose(Nth(i)) == other.pose(Nth(i)));
  REQUIRE(std::hypot(robot.pose(Nth(99)).x_m - before.pose(Nth(99)).x_m,
                     robot.pose(Nth(99)).y_m - before.pose(Nth(99)).y_m) > 0.3);
  for (int i = 90; i < 100; ++i) {
    CheckPose(Inverse(robot.pose(Nth(89))) * robot.pose(Nth(i)), Inverse(before.pose(Nth(89))) * before.pose(Nth(i)),
              1e-9);
  }
}

TEST_CASE("what an update takes out is gone, and an update without poses moves nothing") {
  KeyframeGraph graph = DriveStraight(10);
  graph.Add(MakeKeyframe({1.0, 0.0, 0.0}, ProximityConstraint{Nth(2), {}}));
  const KeyframePoses poses = graph.poses();
  const Loop one{Nth(1), Nth(9), {}};
  const Loop two{Nth(2), Nth(8), {}};
  graph.AddLoop(one);
  GraphUpdate update;
  update.closed = {two};
  update.rejected = {one};
  update.keyframe = Nth(10);
  update.constraints_wrong_from = Nth(3);
  graph.Apply(update);
  CHECK(graph.loops() == std::vector<Loop>{two});
  CHECK(graph.keyframe(Nth(10)).constraint_wrong);
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
  CHECK(graph.size() == 20);
  CHECK(graph.num_trajectories() == 2);
  CHECK(graph.LastOf(0) == KeyframeId{0, 9});
  CHECK(graph.newest() == KeyframeId{1, 9});
  CHECK_FALSE(graph.HangTogether({0, 9}, {1, 0}));
  CHECK_FALSE(graph.is_one_component());
  const auto near = Within(graph, KeyframeId{1, 2}, 1000.0);
  CHECK(near.size() == 10);
  CHECK(near.begin()->first == KeyframeId{1, 0});
}

TEST_CASE("the way is counted along each trajectory from its own beginning") {
  const KeyframeGraph graph = DriveBroken();
  CHECK(graph.path_m({0, 9}) == 9.0);
  CHECK(graph.path_m({1, 0}) == 0.0);
  CHECK(graph.path_m({1, 9}) == 9.0);
  CHECK(graph.FindByPath(0, 100.0) == KeyframeId{0, 9});
  CHECK(graph.FindByPath(1, -1.0) == KeyframeId{1, 0});
  CHECK(graph.FindByPath(1, 2.5) == KeyframeId{1, 3});
  CheckPose(graph.Motion({1, 2}, {1, 5}), {3.0, 0.0, 0.0}, 1e-9);
}

TEST_CASE("keyframes follow each other by their names, also from one trajectory to the next") {
  const KeyframeGraph graph = DriveBroken();
  CHECK_FALSE(graph.Before({0, 0}));
  CHECK(graph.Before({1, 0}) == KeyframeId{0, 9});
  CHECK(graph.Before({1, 1}) == KeyframeId{1, 0});
  CHECK(graph.After({0, 8}) == KeyframeId{0, 9});
  CHECK(graph.After({0, 9}) == KeyframeId{1, 0});
  CHECK_FALSE(graph.After({1, 9}));
  CHECK(graph.CountAfter({0, 0}) == 19);
  CHECK(graph.CountAfter({0, 9}) == 10);
  CHECK(graph.CountAfter({1, 9}) == 0);
  const std::vector<KeyframeId> ids = graph.ids();
  REQUIRE(ids.size() == 20);
  for (std::size_t i = 1; i < ids.size(); ++i) CHECK(graph.After(ids[i - 1]) == ids[i]);
  for (const KeyframeId id : ids) CHECK(graph.Has(id));
  for (const KeyframeId id : {KeyframeId{0, 10}, {1, 10}, {2, 0}, {-1, 0}, {0, -1}}) CHECK_FALSE(graph.Has(id));
  CHECK_FALSE(KeyframeGraph().newest());
}

TEST_CASE("a loop across joins two trajectories: the younger moves; without the loop they fall apart again") {
  KeyframeGraph graph = DriveBroken();
  const Loop loop{{0, 3}, {1, 5}, {0.0, 1.0, 0.25}};
  const KeyframePoses before = graph.poses();
  graph.Join(loop);
  graph.AddLoop(loop);
  CHECK(graph.poses()[0] == before[0]);
  CheckPose(Inverse(graph.pose({0, 3})) * graph.pose({1, 5}), loop.T_older_newer, 1e-9);
  CheckPose(Inverse(graph.pose({1, 0})) * graph.pose({1, 9}), Inverse(before[1][0]) * before[1][9], 1e-9);
  CHECK(graph.HangTogether({0, 0}, {1, 9}));
  CHECK(graph.is_one_component());
  CHECK(graph.FindComponents({}) == std::vector<int>{0, 1});
  CHECK(graph.FindComponents({loop}) == std::vector<int>{0, 0});
  CHECK(Within(graph, KeyframeId{1, 2}, 1000.0).size() == 20);
  graph.DropLoop(loop);
  CHECK_FALSE(graph.HangTogether({0, 0}, {1, 9}));
  CHECK(Within(graph, KeyframeId{1, 2}, 1000.0).size() == 10);
}

/// The same, but the wheels have told the way over the break, too.
KeyframeGraph DriveBridged(const WheelMotion& bridge) {
  KeyframeGraph graph;
  for (int i = 0; i < 20; ++i) {
    Keyframe keyframe = MakeKeyframe({1.0, 0.0, 0.0});
    keyframe.begins = i == 10;
    if (keyframe.begins) keyframe.by_wheels = bridge;
    graph.Add(keyframe);
  }
  return graph;
}

TEST_CASE("where the wheels bridge a break, both sides are one piece, but no way leads across") {
  KeyframeGraph graph = DriveBridged({{1.0, 0.0, 0.0}, 0.1, 0.02});
  CHECK(graph.IsBridged(1));
  CHECK_FALSE(graph.IsBridged(0));
  CHECK_FALSE(graph.HangTogether({0, 0}, {1, 0}));
  CHECK(graph.pieces() == std::vector<int>{0, 0});
  CHECK(Within(graph, KeyframeId{1, 2}, 1000.0).size() == 10);
  CHECK(DriveBroken().pieces() == std::vector<int>{0, 1});
}

TEST_CASE("a bridge tells how well what lies behind it is known, the further away the less") {
  const KeyframeGraph graph = DriveBridged({{1.0, 0.0, 0.0}, 0.3, 0.1});
  const auto at_start = graph.SumBridges({0, 4}, {1, 0});
  REQUIRE(at_start);
  CHECK(at_start->sigma_m == Approx(0.3));
  CHECK(at_start->sigma_rad == Approx(0.1));
  const auto further = graph.SumBridges({0, 4}, {1, 4});
  REQUIRE(further);
  CHECK(further->sigma_m == Approx(0.5));  // 0.3 m, and 0.1 rad over 4 m
  CHECK_FALSE(graph.SumBridges({0, 4}, {0, 9}));
  CHECK_FALSE(DriveBroken().SumBridges({0, 4}, {1, 4}));
}

TEST_CASE("a bridge weighs as much as the wheels are worth") {
  KeyframeGraph graph = DriveBridged({{1.5, 0.0, 0.0}, 0.01, 0.001});  // half a metre more than was guessed
  graph.Optimise();
  CheckPose(Inverse(graph.pose({0, 9})) * graph.pose({1, 0}), {1.5, 0.0, 0.0}, 1e-3);
  graph = DriveBroken();
  const Pose2 guess = Inverse(graph.pose({0, 9})) * graph.pose({1, 0});
  graph.Optimise();
  CheckPose(Inverse(graph.pose({0, 9})) * graph.pose({1, 0}), guess, 1e-3);
}

TEST_CASE("along a degenerate direction the wheels and the match share what a loop moves, by what each is worth") {
  const auto Moved = [](double sigma_m) {
    KeyframeGraph graph;
    for (int i = 0; i < 10; ++i) {
      Keyframe keyframe = MakeKeyframe({1.0, 0.0, 0.0});
      keyframe.degenerate_axis = Eigen::Vector2d(1.0, 0.0);
      if (sigma_m > 0.0 && i == 4) keyframe.by_wheels = WheelMotion{{1.0, 0.0, 0.0}, sigma_m, 0.01};
      graph.Add(keyframe);
    }
    graph.AddLoop({Nth(0), Nth(9), {9.1, 0.0, 0.0}});
    graph.Optimise();
    return (Inverse(graph.pose(Nth(3))) * graph.pose(Nth(4))).x_m - 1.0;
  };
  CHECK(Moved(0.0) == Approx(0.1 / 9).margin(0.003));
  CHECK(Moved(0.01) < 0.2 * Moved(0.0));
  CHECK(Moved(1.0) == Approx(Moved(0.0)).margin(1e-3));
}

TEST_CASE("what is learned of one component leaves the other where it is") {
  KeyframeGraph graph = DriveBroken();
  graph.AddLoop({{1, 0}, {1, 9}, {8.9, 0.0, 0.0}});  // 0.1 m shorter than it was matched
  const KeyframePoses before = graph.poses();
  CHECK(graph.Optimise().empty());
  for (int i = 0; i < 10; ++i) CheckPose(graph.pose({0, i}), At(before, {0, i}), 1e-6);
  CHECK(Length(Inverse(graph.pose({1, 0})) * graph.pose({1, 9})) < 8.99);
}

TEST_CASE("the younger component moves, be it that of the older keyframe") {
  KeyframeGraph graph = DriveBroken();
  for (int i = 0; i < 5; ++i) {  // a third trajectory, which is joined with the first
    Keyframe keyframe = MakeKeyframe(i == 0 ? Pose2{-3.0, 2.0, 0.5} : Pose2{1.0, 0.0, 0.0});
    keyframe.begins = i == 0;
    graph.Add(std::move(keyframe));
  }
  const Loop with_first{{0, 2}, {2, 1}, {0.5, 0.0, 0.1}};
  graph.Join(with_first);
  graph.AddLoop(with_first);
  const KeyframePoses before = graph.poses();
  const Loop with_second{{1, 2}, {2, 3}, {0.0, 1.0, -0.5}};
  graph.Join(with_second);
  CHECK(graph.poses()[0] == before[0]);
  CHECK(graph.poses()[2] == before[2]);
  CheckPose(Inverse(graph.pose({1, 2})) * graph.pose({2, 3}), with_second.T_older_newer, 1e-9);
}

TEST_CASE("an update moves the trajectories that it names, and keyframes of the newest one that came since") {
  KeyframeGraph graph = DriveBroken();
  const KeyframePoses before = graph.poses();
  GraphUpdate update;
  update.keyframe = {1, 6};
  update.moved = {{{0, 4}, {{7.0, 0.0, 0.0}, {8.0, 0.0, 0.0}}}, {{1, 6}, {{0.0, 0.0, 0.0}}}};
  REQUIRE(graph.Fits(update));
  graph.Apply(update);
  for (const KeyframeId id : graph.ids()) {
    const bool has_moved = id == KeyframeId{0, 4} || id == KeyframeId{0, 5} || id >= KeyframeId{1, 6};
    CHECK((graph.pose(id) == At(before, id)) != has_moved);
  }
  CHECK(graph.pose({0, 5}) == Pose2{8.0, 0.0, 0.0});
  CheckPose(graph.pose({1, 9}), {3.0, 0.0, 0.0}, 1e-9);
}

TEST_CASE("an update of keyframes that are not there, or were not yet, does not fit") {
  const KeyframeGraph graph = DriveBroken();
  GraphUpdate good;
  good.keyframe = {1, 6};
  good.previous = KeyframeId{0, 9};
  good.closed = {{{0, 9}, {1, 6}, {}}};
  good.constraints_wrong_from = KeyframeId{0, 3};
  good.moved = {{{0, 0}, std::vector<Pose2>(10)}, {{1, 0}, std::vector<Pose2>(3)}, {{1, 3}, std::vector<Pose2>(4)}};
  REQUIRE(graph.Fits(good));
  const auto Fits = [&](const auto& spoil) {
    GraphUpdate update = good;
    spoil(update);
    return graph.Fits(update);
  };
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.keyframe = {1, 10}; }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.keyframe = {2, 0}; }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.previous = KeyframeId{0, 10}; }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.previous = KeyframeId{1, 6}; }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.closed[0].older = {0, 10}; }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.closed[0].newer = {1, 7}; }));  // not yet
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.closed[0].newer = u.closed[0].older; }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.constraints_wrong_from = KeyframeId{0, 10}; }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.moved[0].poses.emplace_back(); }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.moved[0].first.number = -1; }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.moved[1].first.number = 1; }));      // over the next one
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.moved[2].poses.emplace_back(); }));  // not yet
  CHECK_FALSE(Fits([](GraphUpdate& u) { u.moved[1].poses.clear(); }));
  CHECK_FALSE(Fits([](GraphUpdate& u) { std::swap(u.moved[0], u.moved[1]); }));
}

}  // namespace crsm
