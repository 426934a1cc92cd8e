#include "common/graph/keyframe_graph.hpp"

#include <cmath>
#include <map>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/math/random.hpp"
#include "graph/nth.hpp"

namespace crsm {
namespace {

constexpr Pose2 kAhead{1.0, 0.0, 0.0};

Keyframe MakeKeyframe(const Pose2& T_previous_this,
                      const std::optional<ProximityConstraint>& constraint = std::nullopt) {
  Keyframe keyframe;
  keyframe.T_previous_this = T_previous_this;
  keyframe.constraint = constraint;
  return keyframe;
}

/// Trajectories straight on, of so many keyframes a metre apart. bridge: by wheels, from each to the next.
KeyframeGraph DriveStraight(const std::vector<int>& lengths, const std::optional<WheelMotion>& bridge = {}) {
  KeyframeGraph graph;
  for (const int length : lengths) {
    for (int i = 0; i < length; ++i) {
      const bool begins = i == 0 && graph.size() > 0;
      Keyframe keyframe = MakeKeyframe(begins && !bridge ? Pose2{5.0, 5.0, 1.0} : kAhead);
      keyframe.begins = begins;
      if (begins) keyframe.by_wheels = bridge;
      graph.Add(std::move(keyframe));
    }
  }
  return graph;
}

/// Where the k-th keyframe truly is: round a square of 20 m, a metre a step; step 80 is the start again.
std::vector<Pose2> SquareRound(int num) {
  std::vector<Pose2> poses{{}};
  for (int i = 1; i < num; ++i) poses.push_back(poses.back() * Pose2{1.0, 0.0, i % 20 == 0 ? kPi / 2 : 0.0});
  return poses;
}

/// A drive whose every metre is matched with an error.
KeyframeGraph DriveDrifting(const std::vector<Pose2>& truth, double error_rad) {
  Random random(1);
  KeyframeGraph graph;
  graph.Add(MakeKeyframe({}));
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const Pose2 error{0.003 * random.Gaussian(), 0.003 * random.Gaussian(), error_rad + 0.0005 * random.Gaussian()};
    graph.Add(MakeKeyframe(Inverse(truth[i - 1]) * truth[i] * error));
  }
  return graph;
}

Loop TrueLoop(const std::vector<Pose2>& truth, int older, int newer, const Pose2& error = {}) {
  return {Nth(older), Nth(newer), Inverse(truth[IndexOf(Nth(older))]) * truth[IndexOf(Nth(newer))] * error};
}

double LargestDistance_m(const KeyframeGraph& graph, const std::vector<Pose2>& truth) {
  double largest_m = 0.0;
  for (const KeyframeId id : graph.ids()) {
    const Pose2& right = truth[IndexOf(id)];
    largest_m = std::max(largest_m, std::hypot(graph.pose(id).x_m - right.x_m, graph.pose(id).y_m - right.y_m));
  }
  return largest_m;
}

/// How far those near a keyframe are, by their numbers, which are of its trajectory.
std::map<int, double> Within(const KeyframeGraph& graph, KeyframeId from, double reach_m) {
  std::map<int, double> numbers;
  for (const auto& [id, way_m] : graph.FindWithin(from, reach_m)) {
    REQUIRE(id.trajectory == from.trajectory);
    numbers[id.number] = way_m;
  }
  return numbers;
}

Pose2 FromTo(const KeyframeGraph& graph, KeyframeId from, KeyframeId to) {
  return Inverse(graph.pose(from)) * graph.pose(to);
}

}  // namespace

TEST_CASE("the poses of keyframes follow from the motions between them") {
  KeyframeGraph graph;
  CHECK_FALSE(graph.newest());
  CHECK(graph.Add(MakeKeyframe({5.0, 5.0, 1.0})) == Nth(0));  // of no meaning in the first
  CHECK(graph.Add(MakeKeyframe({3.0, 4.0, kPi / 2})) == Nth(1));
  CHECK(graph.Add(MakeKeyframe(kAhead)) == Nth(2));
  CHECK(graph.size() == 3);
  const Pose2 poses[] = {{}, {3.0, 4.0, kPi / 2}, {3.0, 5.0, kPi / 2}};
  const double ways_m[] = {0.0, 5.0, 6.0};
  for (int i = 0; i < 3; ++i) {
    CheckPose(graph.pose(Nth(i)), poses[i], 1e-9);
    CHECK(graph.path_m(Nth(i)) == Approx(ways_m[i]));
  }
  CheckPose(graph.Motion(Nth(1), Nth(2)), kAhead, 1e-9);
  CheckPose(graph.Motion(Nth(2), Nth(0)) * graph.Motion(Nth(0), Nth(2)), {}, 1e-9);
  CHECK(graph.Motion(Nth(1), Nth(1)) == Pose2{});
}

TEST_CASE("a keyframe is found by its way along the path") {
  const KeyframeGraph graph = DriveStraight({5});
  const std::map<double, int> numbers{{-1.0, 0}, {2.0, 2}, {2.1, 3}, {4.0, 4}, {100.0, 4}};
  for (const auto& [way_m, number] : numbers) CHECK(graph.FindByPath(0, way_m) == Nth(number));
}

TEST_CASE("what is near is near along motions, proximity constraints and loops, by the shortest way") {
  KeyframeGraph graph = DriveStraight({10});
  CHECK(Within(graph, Nth(4), 0.0) == std::map<int, double>{{4, 0.0}});
  CHECK(Within(graph, Nth(4), 2.0) == std::map<int, double>{{2, 2.0}, {3, 1.0}, {4, 0.0}, {5, 1.0}, {6, 2.0}});

  SECTION(
      "a constraint leads to the keyframe it was matched at, until it is dropped; a loop beside it is another way") {
    const KeyframeId constrained = graph.Add(MakeKeyframe(kAhead, ProximityConstraint{Nth(2), {0.3, 0.4, 0.0}}));
    const std::map<int, double> near{{1, 1.5}, {2, 0.5}, {3, 1.5}, {9, 1.0}, {10, 0.0}};
    CHECK(Within(graph, constrained, 1.6) == near);
    const Loop loop{Nth(2), constrained, {0.25, 0.0, 0.0}};
    graph.AddLoop(loop);
    CHECK(Within(graph, constrained, 1.0)[2] == 0.25);
    graph.DropLoop(loop);
    graph.DropConstraints(graph.Add(MakeKeyframe({9.0, 0.0, 0.0})));  // of a newer one
    CHECK(Within(graph, constrained, 1.6) == near);
    graph.DropConstraints(constrained);
    CHECK(Within(graph, constrained, 1.6) == std::map<int, double>{{9, 1.0}, {10, 0.0}});
    CHECK(graph.keyframe(constrained).constraint_wrong);
  }
  SECTION("so does a loop, until it is dropped") {
    const Loop loop{Nth(1), Nth(9), {0.0, 0.5, 3.0}};
    graph.AddLoop(loop);
    CHECK(Within(graph, Nth(9), 1.5) == std::map<int, double>{{0, 1.5}, {1, 0.5}, {2, 1.5}, {8, 1.0}, {9, 0.0}});
    graph.DropLoop({Nth(1), Nth(9), {0.0, 0.6, 3.0}});  // another one, which is not there
    CHECK(graph.loops() == std::vector<Loop>{loop});
    graph.DropLoop(loop);
    CHECK(graph.loops().empty());
    CHECK(Within(graph, Nth(9), 1.5) == std::map<int, double>{{8, 1.0}, {9, 0.0}});
  }
}

TEST_CASE("a loop corrects a square that has drifted, and motions stay as they were matched") {
  const std::vector<Pose2> truth = SquareRound(83);
  KeyframeGraph graph = DriveDrifting(truth, 0.001);
  const double before_m = LargestDistance_m(graph, truth);
  REQUIRE(before_m > 0.7);
  const Pose2 motions[] = {graph.Motion(Nth(3), Nth(77)), graph.Motion(Nth(77), Nth(3))};
  for (const int i : {0, 2}) graph.AddLoop(TrueLoop(truth, i, 80 + i));
  CHECK(graph.Optimise().empty());
  CHECK(graph.loops().size() == 2);
  CHECK(LargestDistance_m(graph, truth) < 0.5 * before_m);
  // The loops are known to 3 cm and 0.005 rad: three deviations.
  CheckPose(FromTo(graph, Nth(0), Nth(80)), TrueLoop(truth, 0, 80).T_older_newer, 0.1);
  CHECK(graph.Motion(Nth(3), Nth(77)) == motions[0]);
  CHECK(graph.Motion(Nth(77), Nth(3)) == motions[1]);
  CHECK(graph.path_m(Nth(82)) == Approx(82.0).margin(0.2));
}

TEST_CASE("a loop that all others contradict is rejected") {
  const std::vector<Pose2> truth = SquareRound(83);
  KeyframeGraph graph = DriveDrifting(truth, 0.0005);
  const Loop wrong = TrueLoop(truth, 10, 50, {4.0, 0.0, 0.0});  // as far as from one door to the next
  graph.AddLoop(wrong);
  for (const int i : {0, 1, 2}) graph.AddLoop(TrueLoop(truth, i, 80 + i));
  CHECK(graph.Optimise() == std::vector<Loop>{wrong});
  CHECK(graph.loops().size() == 3);
  CHECK(Within(graph, Nth(10), 30.0).count(50) == 0);
  CHECK(LargestDistance_m(graph, truth) < 0.3);
  CHECK(graph.Optimise().empty());
}

TEST_CASE("a constraint holds a keyframe at the place where it was matched") {
  KeyframeGraph graph = DriveDrifting(SquareRound(81), 0.001);
  graph.Add(MakeKeyframe(FromTo(graph, Nth(80), Nth(1)), ProximityConstraint{Nth(1), {}}));  // matched where it was
  CHECK(graph.MakePoseGraph().edges().size() == 82);  // 81 motions and the constraint
  graph.Optimise();
  CheckPose(FromTo(graph, Nth(1), Nth(81)), {}, 0.02);
}

TEST_CASE("where a corridor left the position open, and where scans were lost, a motion gives way") {
  const auto DriveTo = [](const Keyframe& second) {
    KeyframeGraph graph = DriveStraight({1});
    graph.Add(second);
    graph.Add(MakeKeyframe(kAhead));
    graph.AddLoop({Nth(0), Nth(2), {2.0, 0.1, 0.0}});
    return graph;
  };
  const auto BendAt = [&](const Keyframe& second) {
    KeyframeGraph graph = DriveTo(second);
    graph.Optimise();
    return graph.pose(Nth(1)).y_m;
  };
  Keyframe keyframe = MakeKeyframe(kAhead);
  const double plain_m = BendAt(keyframe);
  keyframe.after_lost = true;
  CHECK(BendAt(keyframe) > 1.5 * plain_m);
  keyframe.after_lost = false;
  keyframe.degenerate_axis = {0.0, 1.0};
  keyframe.walls.sigma.x_m = 1.0;  // along it nothing is told
  CHECK(BendAt(keyframe) > 1.5 * plain_m);
  keyframe.T_previous_this.yaw_rad = kPi / 2;
  keyframe.degenerate_axis = {1.0, 0.0};  // its own x axis is the first one's y axis
  const auto w = DriveTo(keyframe).MakePoseGraph().edges()[0].sqrt_information;
  const auto Information = [&](std::size_t i) { return w[i] * w[i] + w[3 + i] * w[3 + i]; };
  const double correlated = GraphConstants::Edges().correlated;
  CHECK(Information(0) == Approx(1.0 / correlated / (0.003 * 0.003 + 0.005 * 0.005)));  // across, as everywhere
  CHECK(Information(1) == Approx(1.0 / correlated / (0.4 * 0.4)).epsilon(0.01));        // along: a share of the metre
}

TEST_CASE("what another graph has learned is taken over, and later keyframes follow by their motions") {
  const std::vector<Pose2> truth = SquareRound(100);
  KeyframeGraph robot = DriveDrifting(truth, 0.001);
  KeyframeGraph other = DriveDrifting({truth.begin(), truth.begin() + 90}, 0.001);
  GraphUpdate update;
  update.keyframe = Nth(89);
  update.closed = {TrueLoop(truth, 0, 80), TrueLoop(truth, 5, 85)};
  for (const Loop& loop : update.closed) other.AddLoop(loop);
  other.Optimise();
  update.moved = {{Nth(0), other.poses()[0]}};
  const KeyframeGraph before = robot;
  robot.Apply(update);
  CHECK(robot.loops() == update.closed);
  CHECK(Length(Inverse(before.pose(Nth(99))) * robot.pose(Nth(99))) > 0.3);
  for (int i = 0; i < 100; ++i) {
    if (i < 90) REQUIRE(robot.pose(Nth(i)) == other.pose(Nth(i)));
    if (i >= 90) CheckPose(FromTo(robot, Nth(89), Nth(i)), FromTo(before, Nth(89), Nth(i)), 1e-9);
  }
}

TEST_CASE("what an update takes out is gone, and an update without poses moves nothing") {
  KeyframeGraph graph = DriveStraight({10});
  graph.Add(MakeKeyframe(kAhead, ProximityConstraint{Nth(2), {}}));
  const KeyframePoses poses = graph.poses();
  GraphUpdate update;
  update.closed = {{Nth(2), Nth(8), {}}};
  update.rejected = {{Nth(1), Nth(9), {}}};
  update.keyframe = Nth(10);
  update.constraints_wrong_from = Nth(3);
  graph.AddLoop(update.rejected[0]);
  graph.Apply(update);
  CHECK(graph.loops() == update.closed);
  CHECK(graph.keyframe(Nth(10)).constraint_wrong);
  CHECK(graph.poses() == poses);
}

TEST_CASE("a keyframe that begins a trajectory hangs on nothing before it, and its way is counted from there") {
  const KeyframeGraph graph = DriveStraight({10, 10});
  CHECK(graph.size() == 20);
  CHECK(graph.num_trajectories() == 2);
  CHECK(graph.LastOf(0) == KeyframeId{0, 9});
  CHECK(graph.newest() == KeyframeId{1, 9});
  CHECK_FALSE(graph.HangTogether({0, 9}, {1, 0}));
  CHECK_FALSE(graph.is_one_component());
  CHECK(graph.pieces() == std::vector<int>{0, 1});
  CHECK(Within(graph, {1, 2}, 1000.0).size() == 10);
  CHECK_FALSE(graph.Before({0, 0}));
  CHECK_FALSE(graph.After({1, 9}));
  const std::vector<KeyframeId> ids = graph.ids();
  REQUIRE(ids.size() == 20);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    CHECK(ids[i] == KeyframeId{i < 10 ? 0 : 1, static_cast<int>(i % 10)});
    CHECK(graph.Has(ids[i]));
    CHECK(graph.CountAfter(ids[i]) == static_cast<int>(19 - i));
    if (i == 0) continue;
    CHECK(graph.After(ids[i - 1]) == ids[i]);
    CHECK(graph.Before(ids[i]) == ids[i - 1]);
  }
  for (const KeyframeId id : {KeyframeId{0, 10}, {1, 10}, {2, 0}, {-1, 0}, {0, -1}}) CHECK_FALSE(graph.Has(id));
}

TEST_CASE("a loop across joins two trajectories: the younger moves; without the loop they fall apart again") {
  KeyframeGraph graph = DriveStraight({10, 10});
  const Loop loop{{0, 3}, {1, 5}, {0.0, 1.0, 0.25}};
  const KeyframeGraph before = graph;
  graph.Join(loop);
  graph.AddLoop(loop);
  CHECK(graph.poses()[0] == before.poses()[0]);
  CheckPose(FromTo(graph, {0, 3}, {1, 5}), loop.T_older_newer, 1e-9);
  CheckPose(FromTo(graph, {1, 0}, {1, 9}), FromTo(before, {1, 0}, {1, 9}), 1e-9);
  CHECK(graph.HangTogether({0, 0}, {1, 9}));
  CHECK(graph.is_one_component());
  CHECK(graph.FindComponents({}) == std::vector<int>{0, 1});
  CHECK(graph.FindComponents({loop}) == std::vector<int>{0, 0});
  CHECK(graph.FindWithin({1, 2}, 1000.0).size() == 20);
  graph.DropLoop(loop);
  CHECK_FALSE(graph.HangTogether({0, 0}, {1, 9}));
  CHECK(Within(graph, {1, 2}, 1000.0).size() == 10);
}

TEST_CASE("the younger component moves, be it that of the older keyframe") {
  KeyframeGraph graph = DriveStraight({10, 10, 5});
  const Loop with_first{{0, 2}, {2, 1}, {0.5, 0.0, 0.1}};
  graph.Join(with_first);
  graph.AddLoop(with_first);
  const KeyframePoses before = graph.poses();
  const Loop with_second{{1, 2}, {2, 3}, {0.0, 1.0, -0.5}};
  graph.Join(with_second);
  for (const std::size_t trajectory : {0, 2}) CHECK(graph.poses()[trajectory] == before[trajectory]);
  CheckPose(FromTo(graph, {1, 2}, {2, 3}), with_second.T_older_newer, 1e-9);
}

TEST_CASE(
    "where the wheels bridge a break, both sides are one piece, known the less the further, but no way leads over") {
  const KeyframeGraph graph = DriveStraight({10, 10}, WheelMotion{kAhead, 0.3, 0.1});
  CHECK(graph.IsBridged(1));
  CHECK_FALSE(graph.IsBridged(0));
  CHECK_FALSE(graph.HangTogether({0, 0}, {1, 0}));
  CHECK(graph.pieces() == std::vector<int>{0, 0});
  CHECK(Within(graph, {1, 2}, 1000.0).size() == 10);
  const auto at_start = graph.SumBridges({0, 4}, {1, 0});
  const auto further = graph.SumBridges({0, 4}, {1, 4});
  REQUIRE((at_start && further));
  CHECK(at_start->sigma_m == Approx(0.3));
  CHECK(at_start->sigma_rad == Approx(0.1));
  CHECK(further->sigma_m == Approx(0.5));  // 0.3 m, and 0.1 rad over 4 m
  CHECK_FALSE(graph.SumBridges({0, 4}, {0, 9}));
  CHECK_FALSE(DriveStraight({10, 10}).SumBridges({0, 4}, {1, 4}));
}

TEST_CASE("a bridge weighs as much as the wheels are worth; without one the guess is kept") {
  const WheelMotion bridge{{1.5, 0.0, 0.0}, 0.01, 0.001};  // half a metre more than was guessed
  for (KeyframeGraph graph : {DriveStraight({10, 10}), DriveStraight({10, 10}, bridge)}) {
    const Pose2 expected = graph.IsBridged(1) ? bridge.T_from_to : FromTo(graph, {0, 9}, {1, 0});
    graph.Optimise();
    CheckPose(FromTo(graph, {0, 9}, {1, 0}), expected, 1e-3);
  }
}

TEST_CASE("along a degenerate direction the wheels and the match share what a loop moves, by what each is worth") {
  const auto Moved = [](double sigma_m) {
    KeyframeGraph graph;
    for (int i = 0; i < 10; ++i) {
      Keyframe keyframe = MakeKeyframe(kAhead);
      keyframe.degenerate_axis = {1.0, 0.0};
      keyframe.walls.sigma.x_m = 1.0;
      if (sigma_m > 0.0 && i == 4) keyframe.by_wheels = WheelMotion{kAhead, sigma_m, 0.01};
      graph.Add(keyframe);
    }
    graph.AddLoop({Nth(0), Nth(9), {9.1, 0.0, 0.0}});
    graph.Optimise();
    return FromTo(graph, Nth(3), Nth(4)).x_m - 1.0;
  };
  CHECK(Moved(0.0) == Approx(0.1 / 9).margin(0.003));
  CHECK(Moved(0.01) < 0.2 * Moved(0.0));
  CHECK(Moved(10.0) == Approx(Moved(0.0)).margin(1e-3));
}

TEST_CASE("what is learned of one component leaves the other where it is") {
  KeyframeGraph graph = DriveStraight({10, 10});
  graph.AddLoop({{1, 0}, {1, 9}, {8.9, 0.0, 0.0}});  // 0.1 m shorter than it was matched
  const KeyframePoses before = graph.poses();
  CHECK(graph.Optimise().empty());
  for (int i = 0; i < 10; ++i) CheckPose(graph.pose({0, i}), At(before, {0, i}), 1e-6);
  CHECK(Length(FromTo(graph, {1, 0}, {1, 9})) < 8.996);
}

TEST_CASE("an update moves the trajectories that it names, and keyframes of the newest one that came since") {
  KeyframeGraph graph = DriveStraight({10, 10});
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
  const KeyframeGraph graph = DriveStraight({10, 10});
  GraphUpdate good;
  good.keyframe = {1, 6};
  good.previous = KeyframeId{0, 9};
  good.closed = {{{0, 9}, {1, 6}, {}}};
  good.finding = LoopFinding{{0, 3}, {1, 6}, {}, 0.75};
  good.constraints_wrong_from = KeyframeId{0, 3};
  good.moved = {{{0, 0}, std::vector<Pose2>(10)}, {{1, 0}, std::vector<Pose2>(3)}, {{1, 3}, std::vector<Pose2>(4)}};
  REQUIRE(graph.Fits(good));
  using Spoil = void (*)(GraphUpdate&);
  const Spoil spoils[] = {
      [](GraphUpdate& u) {
        u.keyframe = {1, 10};
      },
      [](GraphUpdate& u) {
        u.keyframe = {2, 0};
      },
      [](GraphUpdate& u) {
        u.previous = KeyframeId{0, 10};
      },
      [](GraphUpdate& u) {
        u.previous = KeyframeId{-1, 2};
      },
      [](GraphUpdate& u) {
        u.previous = KeyframeId{1, 6};
      },
      [](GraphUpdate& u) {
        u.finding->older = {1, 6};
      },
      [](GraphUpdate& u) {
        u.finding->older = {0, -1};
      },
      [](GraphUpdate& u) {
        u.finding->newer = {1, 5};
      },
      [](GraphUpdate& u) {
        u.closed[0].older = {0, 10};
      },
      [](GraphUpdate& u) {
        u.closed[0].newer = {1, 7};
      },  // not yet
      [](GraphUpdate& u) { u.closed[0].newer = u.closed[0].older; },
      [](GraphUpdate& u) {
        u.rejected = {{{0, -1}, {0, 3}, {}}};
      },
      [](GraphUpdate& u) {
        u.constraints_wrong_from = KeyframeId{0, 10};
      },
      [](GraphUpdate& u) { u.moved[0].poses.emplace_back(); },
      [](GraphUpdate& u) { u.moved[0].first.number = -1; },
      [](GraphUpdate& u) { u.moved[1].first.number = 1; },      // over the next one
      [](GraphUpdate& u) { u.moved[2].poses.emplace_back(); },  // not yet
      [](GraphUpdate& u) { u.moved[1].poses.clear(); },
      [](GraphUpdate& u) { u.moved[0].poses[7].x_m = -1e6; },
      [](GraphUpdate& u) { u.moved[0].poses[7].y_m = NAN; },
      [](GraphUpdate& u) { std::swap(u.moved[0], u.moved[1]); },
  };
  for (std::size_t i = 0; i < std::size(spoils); ++i) {
    CAPTURE(i);
    GraphUpdate update = good;
    spoils[i](update);
    CHECK_FALSE(graph.Fits(update));
  }
}

TEST_CASE("a graph hands its constants to the optimisation, and leaves poses that hardly move") {
  const std::vector<Pose2> truth = SquareRound(83);
  const auto Optimise = [&](const GraphConstants::Edges& constants) {
    const KeyframeGraph drifting = DriveDrifting(truth, 0.001);
    KeyframeGraph graph(constants);
    for (const KeyframeId id : drifting.ids()) graph.Add(drifting.keyframe(id));
    graph.AddLoop(TrueLoop(truth, 0, 80));
    graph.Optimise();
    return graph.poses() != drifting.poses();
  };
  CHECK(Optimise({}));
  CHECK_FALSE(Optimise({.hardly = 100.0}));
  CHECK_FALSE(Optimise({.optimisation = {.steps_per_doubt = 0, .steps_max = 0}}));
}

}  // namespace crsm
