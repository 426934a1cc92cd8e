#include "services/wire/graph_messages.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "graph/nth.hpp"
#include "send.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kEpoch = 99;

Pose2 DrawPose(Random& random) {
  return {random.Uniform(-100.0, 100.0), random.Uniform(-100.0, 100.0), random.Uniform(-kPi, kPi)};
}

Keyframe MakeKeyframe() {
  Random random(3);
  Keyframe keyframe;
  keyframe.utime = 1234567890123456;
  keyframe.rays = ValidRays{{-1.0f / 3.0f, 0.1f, 2.0f}, {0.7f, 1.0f / 7.0f, 30.0f}};
  keyframe.T_previous_this = DrawPose(random);
  keyframe.by_wheels = WheelMotion{DrawPose(random), 0.03, 0.01};
  keyframe.as_of = Nth(3);
  return keyframe;
}

void CheckSame(const Keyframe& one, const Keyframe& other) {
  CHECK(one.utime == other.utime);
  CHECK(one.rays == other.rays);
  CHECK(one.T_previous_this == other.T_previous_this);
  CHECK(one.by_wheels == other.by_wheels);
  CHECK(one.after_lost == other.after_lost);
  CHECK(one.begins == other.begins);
  CHECK(one.begins_anywhere == other.begins_anywhere);
  CHECK(one.degenerate_axis == other.degenerate_axis);
  CHECK(one.walls == other.walls);
  CHECK(one.constraint == other.constraint);
  CHECK(one.as_of == other.as_of);
}

/// Poses from `first_pose` to `keyframe`, and loops of all kinds.
GraphUpdate MakeUpdate(int first_pose, int keyframe) {
  Random random(static_cast<std::uint64_t>(keyframe));
  GraphUpdate update;
  update.keyframe = Nth(keyframe);
  update.previous = Nth(7);
  update.closed = {{Nth(3), Nth(keyframe), DrawPose(random)}, {Nth(5), Nth(keyframe - 4), DrawPose(random)}};
  update.rejected = {{Nth(1), Nth(40), DrawPose(random)}};
  update.moved = {{Nth(first_pose), {}}};
  for (int i = first_pose; i <= keyframe; ++i) update.moved[0].poses.push_back(DrawPose(random));
  return update;
}

/// What the parts come to, one after the other; only the last may make the update whole.
std::optional<GraphUpdate> PutTogether(const std::vector<pose_graph_t>& parts, GraphUpdateParts& together) {
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) REQUIRE_FALSE(together.Add(Send(parts[i])));
  return together.Add(Send(parts.back()));
}
std::optional<GraphUpdate> PutTogether(const std::vector<pose_graph_t>& parts) {
  GraphUpdateParts together;
  return PutTogether(parts, together);
}

}  // namespace

TEST_CASE("a keyframe comes over the wire to the last bit") {
  Keyframe keyframe = MakeKeyframe();
  SECTION("as it is") {}
  SECTION("with what is not known of its motion") {
    keyframe.after_lost = true;
    keyframe.as_of.reset();
    keyframe.degenerate_axis = {std::cos(0.3), std::sin(0.3)};
    keyframe.walls = {{std::cos(0.4), std::sin(0.4)}, {0.3, 0.01, 0.002}};
  }
  SECTION("with a constraint") { keyframe.constraint = ProximityConstraint{Nth(17), {0.1, -0.2, 1.0 / 3.0}}; }
  SECTION("with a constraint to the first keyframe, at its very place") {
    keyframe.constraint = ProximityConstraint{Nth(0), {}};
  }
  SECTION("without rays") { keyframe.rays = {}; }
  const keyframe_t message = Send(ToMessage(keyframe, {kEpoch, Nth(20), Nth(19), Nth(12)}));
  CHECK(message.epoch == kEpoch);
  CHECK(FromMessage(message.id) == Nth(20));
  CHECK(FromOptional(message.previous) == Nth(19));
  CHECK(FromOptional(message.last_update) == Nth(12));
  CheckSame(FromMessage(message), keyframe);
  keyframe.constraint_wrong = true;  // what a receiver has found out of a constraint is its own
  CHECK_FALSE(FromMessage(Send(ToMessage(keyframe, {kEpoch, Nth(20), Nth(19)}))).constraint_wrong);
}

TEST_CASE("a keyframe without number 0 goes on with a trajectory, one with it begins one") {
  Keyframe keyframe = MakeKeyframe();
  keyframe.begins = true;
  keyframe.as_of.reset();
  const keyframe_t first_of_all = Send(ToMessage(keyframe, {kEpoch, {0, 0}}));
  CHECK(FromMessage(first_of_all).begins);
  CHECK_FALSE(FromOptional(first_of_all.previous));
  CHECK_FALSE(FromOptional(first_of_all.last_update));
  const keyframe_t after_a_break = Send(ToMessage(keyframe, {kEpoch, {1, 0}, Nth(19)}));
  CHECK(FromMessage(after_a_break).begins);
  CHECK(FromOptional(after_a_break.previous) == Nth(19));
  CHECK_FALSE(FromMessage(after_a_break).begins_anywhere);
  CHECK_FALSE(FromMessage(Send(ToMessage(keyframe, {kEpoch, {1, 1}, KeyframeId{1, 0}}))).begins);
  keyframe.begins_anywhere = true;  // of another drive
  CHECK(FromMessage(Send(ToMessage(keyframe, {kEpoch, {1, 0}, Nth(19)}))).begins_anywhere);
}

TEST_CASE("what was found at a keyframe comes over the wire to the last bit") {
  const LoopFinding finding{Nth(3), Nth(20), {1.0 / 3.0, -0.7, 0.1}, 0.9, LoopFinding::By::kNearby};
  const auto OverTheWire = [](const std::optional<EarlierSearch>& search) {
    return FindSearch(Send(ToMessage(Keyframe{}, {kEpoch, Nth(20), Nth(19), Nth(12), search})));
  };
  CHECK_FALSE(OverTheWire({}));
  REQUIRE(OverTheWire(EarlierSearch{}));
  CHECK_FALSE(OverTheWire(EarlierSearch{})->finding);
  REQUIRE(OverTheWire(EarlierSearch{finding}));
  CHECK(OverTheWire(EarlierSearch{finding})->finding == finding);

  GraphUpdate update;  // which changes nothing
  update.keyframe = Nth(20);
  update.finding = finding;
  CHECK(PutTogether(MakeParts(update, 5, kEpoch)) == update);
}

TEST_CASE("an update comes over the wire to the last bit, in parts of 32 KB at most") {
  GraphUpdate update = MakeUpdate(0, 2499);
  std::size_t num_parts = 3;
  SECTION("of 2500 poses") {}
  SECTION("with constraints that are wrong") { update.constraints_wrong_from = Nth(0); }
  SECTION("with what was found") {
    update.finding = LoopFinding{Nth(3), update.keyframe, {1.0 / 3.0, -0.7, 0.1}, 0.9, LoopFinding::By::kCheck};
  }
  SECTION("of the last poses only") {
    update = MakeUpdate(1700, 2499);
    num_parts = 1;
  }
  SECTION("of as many poses as fit into two parts") {
    update = MakeUpdate(502, 2499);
    num_parts = 2;
  }
  SECTION("of one pose more") {
    update = MakeUpdate(501, 2499);
    num_parts = 3;
  }
  SECTION("without loops or poses") {
    update = {};
    update.keyframe = Nth(60);
    num_parts = 1;
  }
  SECTION("of several trajectories, cut in the midst of one and at the end of another") {
    update.keyframe = {3, 999};
    update.moved = {{{0, 5}, std::vector<Pose2>(700)},
                    {{1, 0}, std::vector<Pose2>(500)},
                    {{2, 0}, std::vector<Pose2>(800)},
                    {{3, 300}, std::vector<Pose2>(300)}};
  }
  SECTION("of many short trajectories") {
    update.keyframe = {2600, 0};
    update.moved.clear();
    for (int i = 0; i <= 2600; i += 2) update.moved.push_back({{i, 0}, {{0.5 * i, 0.0, 0.0}}});
    num_parts = 3;
  }
  const auto parts = MakeParts(update, 5, kEpoch);
  REQUIRE(parts.size() == num_parts);
  for (const pose_graph_t& part : parts) {
    CHECK(Encode(part).size() <= 32768);
    CHECK(part.utime == 5);
    CHECK(part.epoch == kEpoch);
    CHECK(FromMessage(part.keyframe) == update.keyframe);
    CHECK(part.changed == 1);
  }
  CHECK(PutTogether(parts) == update);
}

TEST_CASE("the parts of an update may come in any order, and twice, and of a whole one nothing is left") {
  const GraphUpdate update = MakeUpdate(0, 2499);
  const auto parts = MakeParts(update, 5, kEpoch);
  std::vector<int> order{0, 1, 2};
  do {
    CAPTURE(order);
    std::vector<pose_graph_t> coming;
    for (const int i : order) coming.push_back(parts[static_cast<std::size_t>(i)]);
    CHECK(PutTogether(coming) == update);
    coming.insert(coming.begin() + 1, coming.front());
    coming.insert(coming.begin(), coming[2]);
    CHECK(PutTogether(coming) == update);
  } while (std::next_permutation(order.begin(), order.end()));
  GraphUpdateParts together;  // of one update after the other; sent again, it takes all of its parts again
  for (const GraphUpdate& next : {update, MakeUpdate(300, 2600), MakeUpdate(300, 2600)}) {
    CHECK(PutTogether(MakeParts(next, 5, kEpoch), together) == next);
  }
}

TEST_CASE("an update whose parts are followed by those of another one is given up") {
  const GraphUpdate update = MakeUpdate(0, 2499);
  GraphUpdate other = update;
  std::int64_t epoch = kEpoch;
  SECTION("of a later keyframe") { other = MakeUpdate(0, 2550); }
  SECTION("that follows another one") { other.previous = Nth(9); }
  SECTION("of another map") { epoch = kEpoch + 1; }
  SECTION("in fewer parts") { other = MakeUpdate(1000, 2499); }
  const auto parts = MakeParts(update, 5, kEpoch);
  auto others = MakeParts(other, 5, epoch);
  std::reverse(others.begin(), others.end());  // the one that would be the last of both comes first
  GraphUpdateParts together;
  REQUIRE_FALSE(together.Add(parts[0]));
  REQUIRE_FALSE(together.Add(parts[1]));
  CHECK(PutTogether(others, together) == other);
  CHECK_FALSE(together.Add(parts[2]));  // the first two are gone
}

TEST_CASE("parts whose poses are not in place make an update that fits no graph") {
  const GraphUpdate update = MakeUpdate(0, 2499);
  const auto parts = MakeParts(update, 5, kEpoch);
  KeyframeGraph graph;
  for (int i = 0; i <= 2499; ++i) graph.Add({});
  for (const int shift : {-1, 0, 1}) {
    auto shifted = parts;
    shifted[1].moved[0].first.number += shift;
    const auto together = PutTogether(shifted);
    REQUIRE(together);
    CHECK(graph.Fits(*together) == (shift == 0));
  }
}

TEST_CASE("how many parts an update can have is known from the keyframes of its graph") {
  CHECK(MostParts(0) == 1);
  CHECK(MakeParts(MakeUpdate(0, 2499), 5, kEpoch).size() <= static_cast<std::size_t>(MostParts(2500)));
  GraphUpdate update;  // of trajectories of one keyframe each
  update.keyframe = {2499, 0};
  for (int i = 0; i < 2500; ++i) update.moved.push_back({{i, 0}, {{}}});
  CHECK(MakeParts(update, 5, kEpoch).size() <= static_cast<std::size_t>(MostParts(2500)));
}

TEST_CASE("that nothing has changed is said in one part with nothing in it") {
  const pose_graph_t message = Send(MakeUnchanged(Nth(60), Nth(60), 5, kEpoch));
  CHECK(message.utime == 5);
  CHECK(message.epoch == kEpoch);
  CHECK(FromMessage(message.keyframe) == Nth(60));
  CHECK(FromOptional(message.previous) == Nth(60));
  CHECK(message.changed == 0);
  CHECK(message.num_parts == 1);
  CHECK_FALSE(FromOptional(message.constraints_wrong_from));
  CHECK(message.num_closed == 0);
  CHECK(message.num_rejected == 0);
  CHECK(message.num_moved == 0);
}

}  // namespace crsm
