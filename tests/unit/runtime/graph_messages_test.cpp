#include "services/runtime/graph_messages.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr std::int64_t kEpoch = 99;

/// Over the wire: what a receiver gets of it.
template <class Message>
Message Send(const Message& message) {
  const auto received = Decode<Message>(Encode(message));
  REQUIRE(received);
  return *received;
}

Pose2 DrawPose(Random& random) {
  return {random.Uniform(-100.0, 100.0), random.Uniform(-100.0, 100.0), random.Uniform(-kPi, kPi)};
}

Keyframe MakeKeyframe() {
  Random random(3);
  Keyframe keyframe;
  keyframe.utime = 1234567890123456;
  keyframe.rays = {{-1.0f / 3.0f, 0.1f, 2.0f}, {0.7f, 1.0f / 7.0f, 30.0f}};
  keyframe.T_previous_this = DrawPose(random);
  keyframe.as_of = 3;
  return keyframe;
}

void CheckSame(const Keyframe& one, const Keyframe& other) {
  CHECK(one.utime == other.utime);
  CHECK(one.rays == other.rays);
  CHECK(one.T_previous_this == other.T_previous_this);
  CHECK(one.after_lost == other.after_lost);
  CHECK(one.begins == other.begins);
  CHECK(one.open_axis == other.open_axis);
  CHECK(one.tie == other.tie);
  CHECK(one.as_of == other.as_of);
}

/// Poses from `first_pose` to `keyframe`, and loops of all kinds.
GraphUpdate MakeUpdate(int first_pose, int keyframe) {
  Random random(static_cast<std::uint64_t>(keyframe));
  GraphUpdate update;
  update.keyframe = keyframe;
  update.previous = 7;
  update.closed = {{3, keyframe, DrawPose(random)}, {5, keyframe - 4, DrawPose(random)}};
  update.taken_out = {{1, 40, DrawPose(random)}};
  update.first_pose = first_pose;
  for (int i = first_pose; i <= keyframe; ++i) update.poses.push_back(DrawPose(random));
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
    keyframe.begins = true;
    keyframe.as_of = -1;
    keyframe.open_axis = Eigen::Vector2d(std::cos(0.3), std::sin(0.3));
  }
  SECTION("with a tie") { keyframe.tie = Tie{17, {0.1, -0.2, 1.0 / 3.0}}; }
  SECTION("tied to the first keyframe, at its very place") { keyframe.tie = Tie{0, {}}; }
  SECTION("without rays") { keyframe.rays = {}; }
  const keyframe_t message = Send(ToMessage(keyframe, {kEpoch, 20, 12}));
  CHECK(message.epoch == kEpoch);
  CHECK(message.keyframe == 20);
  CHECK(message.last_update == 12);
  CheckSame(FromMessage(message), keyframe);
}

TEST_CASE("what a receiver has found out of a tie is its own and does not travel") {
  Keyframe keyframe = MakeKeyframe();
  keyframe.tie = Tie{17, {}};
  keyframe.tie_wrong = true;
  CHECK_FALSE(FromMessage(Send(ToMessage(keyframe, {kEpoch, 20, 12}))).tie_wrong);
}

TEST_CASE("an update comes over the wire to the last bit, in parts of 32 KB at most") {
  GraphUpdate update = MakeUpdate(0, 2499);
  std::size_t num_parts = 3;
  SECTION("of 2500 poses") {}
  SECTION("with ties that are wrong") { update.ties_wrong_from = 0; }
  SECTION("of the last poses only") {
    update = MakeUpdate(1700, 2499);
    num_parts = 1;
  }
  SECTION("of as many poses as fit into two parts") {
    update = MakeUpdate(500, 2499);
    num_parts = 2;
  }
  SECTION("of one pose more") {
    update = MakeUpdate(499, 2499);
    num_parts = 3;
  }
  SECTION("without loops or poses") {
    update = {};
    update.keyframe = 60;
    update.first_pose = 61;
    num_parts = 1;
  }
  const auto parts = MakeParts(update, 5, kEpoch);
  REQUIRE(parts.size() == num_parts);
  for (const pose_graph_t& part : parts) {
    CHECK(Encode(part).size() <= 32768);
    CHECK(part.utime == 5);
    CHECK(part.epoch == kEpoch);
    CHECK(part.keyframe == update.keyframe);
    CHECK(part.changed == 1);
  }
  CHECK(PutTogether(parts) == update);
}

TEST_CASE("the parts of an update may come in any order, and twice") {
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
}

TEST_CASE("one update comes after the other, and of a whole one nothing is left") {
  GraphUpdateParts together;
  const GraphUpdate first = MakeUpdate(0, 2499);
  const GraphUpdate second = MakeUpdate(300, 2600);
  CHECK(PutTogether(MakeParts(first, 5, kEpoch), together) == first);
  CHECK(PutTogether(MakeParts(second, 6, kEpoch), together) == second);
  CHECK(PutTogether(MakeParts(second, 6, kEpoch), together) == second);  // sent again, it takes all of its parts again
}

TEST_CASE("an update whose parts are followed by those of another one is given up") {
  const GraphUpdate update = MakeUpdate(0, 2499);
  GraphUpdate other = update;
  std::int64_t epoch = kEpoch;
  SECTION("of a later keyframe") { other = MakeUpdate(0, 2550); }
  SECTION("that follows another one") { other.previous = 9; }
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

TEST_CASE("parts whose poses are not in place make no update, and the next one is not the worse for it") {
  const GraphUpdate update = MakeUpdate(0, 2499);
  const auto parts = MakeParts(update, 5, kEpoch);
  for (const int shift : {-1, 1}) {
    auto shifted = parts;
    shifted[1].first_pose += shift;
    GraphUpdateParts together;
    CHECK_FALSE(PutTogether(shifted, together));
    CHECK(PutTogether(parts, together) == update);
  }
}

TEST_CASE("a part that claims more parts than poses can be does not take the place of those that are right") {
  const GraphUpdate update = MakeUpdate(0, 2499);
  const auto parts = MakeParts(update, 5, kEpoch);
  GraphUpdateParts together;
  REQUIRE_FALSE(together.Add(parts[0]));
  pose_graph_t wrong = parts[1];
  wrong.num_parts = 4;
  CHECK_FALSE(together.Add(wrong));
  CHECK_FALSE(together.Add(parts[1]));
  CHECK(together.Add(parts[2]) == update);
}

TEST_CASE("that nothing has changed is said in one part with nothing in it") {
  const pose_graph_t message = Send(MakeUnchanged(60, 60, 5, kEpoch));
  CHECK(message.utime == 5);
  CHECK(message.epoch == kEpoch);
  CHECK(message.keyframe == 60);
  CHECK(message.previous == 60);
  CHECK(message.changed == 0);
  CHECK(message.num_parts == 1);
  CHECK(message.ties_wrong_from == -1);
  CHECK(message.num_closed == 0);
  CHECK(message.num_taken_out == 0);
  CHECK(message.num_poses == 0);
}

}  // namespace crsm
