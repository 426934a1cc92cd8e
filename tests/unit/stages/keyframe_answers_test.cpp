#include "services/stages/keyframe_answers.hpp"

#include <map>
#include <utility>

#include "catch.hpp"
#include "common/graph/default_loop_closer.hpp"
#include "graph/block.hpp"
#include "graph/nth.hpp"
#include "services/wire/graph_messages.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr LoopParameters kLoops{true, 40.0};
const MakeLoopCloser kMakeCloser = DefaultLoopCloser(kLoops, UpdateParameters{});
constexpr std::int64_t kEpoch = 7;

/// Round a block and on, so that loops are closed.
const std::vector<Keyframe>& Drive() {
  static const std::vector<Keyframe> keyframes =
      MakeKeyframes(MakeBlock(7), DriveRoundBlock(5.0, 5.0 + 1.4 * kRoundBlock_m), {0.0, 0.001, 0.0008}, 7);
  return keyframes;
}
int DriveSize() { return static_cast<int>(Drive().size()); }

KeyframeHead Head(int keyframe, int last_update, std::int64_t epoch = kEpoch) {
  return {epoch, Nth(keyframe), NthOrNone(keyframe - 1), NthOrNone(last_update)};
}

/// What its owner says of a keyframe of the drive, over the wire; -1: there was no update.
keyframe_t Tell(int keyframe, int last_update, std::int64_t epoch = kEpoch) {
  const auto message = Decode<keyframe_t>(
      Encode(ToMessage(Drive()[static_cast<std::size_t>(keyframe)], Head(keyframe, last_update, epoch))));
  REQUIRE(message);
  return *message;
}

std::vector<std::vector<std::uint8_t>> Encode(const std::vector<pose_graph_t>& messages) {
  std::vector<std::vector<std::uint8_t>> bytes;
  for (const pose_graph_t& message : messages) {
    bytes.push_back(crsm::Encode(message));
    CHECK(Decode<pose_graph_t>(bytes.back()));
  }
  return bytes;
}

/// Where the drive closes its loops, by the loop closer alone.
const std::vector<GraphUpdate>& Updates() {
  static const std::vector<GraphUpdate> updates = [] {
    std::vector<GraphUpdate> found;
    const auto closer = kMakeCloser();
    for (const Keyframe& keyframe : Drive()) {
      if (auto update = closer->Add(keyframe, {})) found.push_back(std::move(*update));
    }
    return found;
  }();
  REQUIRE(updates.size() >= 2);
  return updates;
}

std::vector<pose_graph_t> PartsOf(const GraphUpdate& update) {
  return MakeParts(update, Drive()[IndexOf(update.keyframe)].utime, kEpoch);
}

pose_graph_t Unchanged(int keyframe, int previous, std::int64_t epoch = kEpoch) {
  return MakeUnchanged(Nth(keyframe), NthOrNone(previous), Drive()[static_cast<std::size_t>(keyframe)].utime, epoch);
}

/// Who has heard so many keyframes.
KeyframeAnswers MakeAnswers(int num_keyframes = 0) {
  KeyframeAnswers answers(kMakeCloser);
  for (int i = 0; i < num_keyframes; ++i) answers.Answer(Tell(i, -1));
  return answers;
}

/// Who has heard all keyframes before the one that closes the first loop.
KeyframeAnswers BeforeFirstUpdate() { return MakeAnswers(Updates()[0].keyframe.number); }

/// Whether nothing is known, and all keyframes are asked for.
bool BeginsAnew(KeyframeAnswers& answers) {
  const auto request = answers.NextRequest();
  return answers.graph().size() == 0 && request && !FromOptional(request->after);
}

}  // namespace

TEST_CASE("each keyframe is answered by what it has brought, or by that nothing has changed") {
  KeyframeAnswers answers = MakeAnswers();
  std::size_t num_updates = 0;
  int last_update = -1;
  for (int i = 0; i < DriveSize(); ++i) {
    const auto answer = Encode(answers.Answer(Tell(i, last_update)));
    if (num_updates < Updates().size() && Updates()[num_updates].keyframe == Nth(i)) {
      REQUIRE(answer == Encode(PartsOf(Updates()[num_updates++])));
      last_update = i;
    } else {
      REQUIRE(answer == Encode({Unchanged(i, last_update)}));
    }
    REQUIRE(answers.last_update() == NthOrNone(last_update));
    REQUIRE_FALSE(answers.NextRequest());
  }
  CHECK(num_updates == Updates().size());
  CHECK(answers.graph().size() == DriveSize());
  CHECK_FALSE(answers.is_of_another_closer());
}

TEST_CASE("a loop closer that is started anew does not search where the owner says what was found") {
  const int known = Updates()[1].keyframe.number;
  std::map<KeyframeId, LoopFinding> findings;
  for (const GraphUpdate& update : Updates()) findings.emplace(update.keyframe, *update.finding);
  KeyframeAnswers answers = MakeAnswers();
  for (int i = 0; i <= known + 5; ++i) {
    keyframe_t message = Tell(i, i < known ? -1 : known);
    if (i <= known) {
      const auto found = findings.find(Nth(i));
      KeyframeHead head = Head(i, known);
      head.search = EarlierSearch{found == findings.end() ? std::nullopt : std::optional(found->second)};
      message = ToMessage(Drive()[static_cast<std::size_t>(i)], head);
    }
    answers.Answer(message);
  }
  CHECK(answers.num_searched() == 5);
  CHECK(answers.last_update() >= Nth(known));
  CHECK_FALSE(answers.is_of_another_closer());
  const KeyframeAnswers all = MakeAnswers(known + 6);
  CHECK(all.num_searched() == known + 6);
  CHECK(answers.graph().poses() == all.graph().poses());
  CHECK(answers.graph().loops() == all.graph().loops());
}

TEST_CASE("a keyframe at which something was found that lies in no keyframe known here waits") {
  KeyframeAnswers answers = MakeAnswers(5);
  keyframe_t message = Tell(5, -1);
  message.id = {1, 0};
  message.previous = {0, 4};
  message.searched = 1;
  message.num_findings = 1;
  message.findings = {loop_finding_t{{0, 5}, {}, 0.8, loop_finding_t::ANYWHERE}};
  CHECK(answers.Answer(message).empty());
  CHECK(answers.graph().size() == 5);
  message.findings[0].older = {0, 4};
  CHECK_FALSE(answers.Answer(message).empty());
  CHECK(answers.graph().size() == 6);
}

TEST_CASE("an owner that begins with an update at its newest keyframe is told that loops were looked for there") {
  const int newest = Updates()[0].keyframe.number;
  KeyframeAnswers answers = MakeAnswers();
  for (int i = 0; i < newest; ++i) CHECK(answers.Answer(Tell(i, newest)).empty());
  CHECK(Encode(answers.Answer(Tell(newest, newest))) == Encode({Unchanged(newest, newest)}));
}

TEST_CASE("all updates that an owner lacks are given in their order, and again, until it says that it has them") {
  KeyframeAnswers answers = BeforeFirstUpdate();
  const int first = Updates()[0].keyframe.number;
  const int last = Updates()[1].keyframe.number;
  const auto Answer = [&](int keyframe, int last_update) {
    return Encode(answers.Answer(Tell(keyframe, last_update)));
  };
  std::vector<pose_graph_t> expected = PartsOf(Updates()[0]);
  for (int time = 0; time < 2; ++time) CHECK(Answer(first, -1) == Encode(expected));
  CHECK(answers.graph().size() == first + 1);  // it is no new one
  for (int i = first + 1; i < last; ++i) {
    expected.push_back(Unchanged(i, first));
    CHECK(Answer(i, -1) == Encode(expected));
    expected.pop_back();
  }
  for (const pose_graph_t& part : PartsOf(Updates()[1])) expected.push_back(part);
  CHECK(Answer(last, -1) == Encode(expected));
  CHECK(Answer(first, -1) == Encode(PartsOf(Updates()[0])));  // sent again: not more than was known then
  CHECK(Answer(last, first) == Encode(PartsOf(Updates()[1])));
  for (int time = 0; time < 2; ++time) CHECK(Answer(last + 1, last) == Encode({Unchanged(last + 1, last)}));
}

TEST_CASE("as many keyframes are asked for at once as a receiver surely keeps") {
  const auto Asked = [](std::size_t num_rays) {
    KeyframeAnswers answers = MakeAnswers();
    Keyframe keyframe;
    ValidRays rays;
    for (std::size_t i = 0; i < num_rays; ++i) {
      rays.angle_rad.push_back(0.001f * static_cast<float>(i));
      rays.range_m.push_back(2.0f);
    }
    keyframe.rays = rays;
    answers.Answer(ToMessage(keyframe, Head(0, -1)));
    answers.Answer(ToMessage(keyframe, Head(100, -1)));
    return answers.NextRequest()->num_keyframes;
  };
  CHECK(Asked(0) == 64);
  CHECK(Asked(100) == 64);
  CHECK(Asked(1000) == 8);
  CHECK(Asked(4096) == 1);
}

TEST_CASE("another map begins with another graph") {
  KeyframeAnswers answers = BeforeFirstUpdate();
  const int k = Updates()[0].keyframe.number;
  answers.Answer(Tell(k, -1));
  REQUIRE(answers.last_update() == Nth(k));
  CHECK(Encode(answers.Answer(Tell(0, -1, kEpoch + 1))) == Encode({Unchanged(0, -1, kEpoch + 1)}));
  CHECK(answers.graph().size() == 1);
  CHECK_FALSE(answers.last_update());
  CHECK_FALSE(answers.NextRequest());  // of the other map's keyframes nothing is lacking
  CHECK(Encode(answers.Answer(Tell(1, -1, kEpoch + 1))) == Encode({Unchanged(1, -1, kEpoch + 1)}));
}

TEST_CASE("an owner that no longer has an update is given all again, from the first keyframe on") {
  KeyframeAnswers answers = BeforeFirstUpdate();
  const int k = Updates()[0].keyframe.number;
  answers.Answer(Tell(k, -1));
  answers.Answer(Tell(k + 1, k));  // it has it, and nobody has to keep it
  CHECK(answers.Answer(Tell(k, -1)).empty());
  CHECK(BeginsAnew(answers));
  for (int i = 0; i < k; ++i) REQUIRE(Encode(answers.Answer(Tell(i, -1))) == Encode({Unchanged(i, -1)}));
  CHECK(Encode(answers.Answer(Tell(k, -1))) == Encode(PartsOf(Updates()[0])));
  CHECK_FALSE(answers.NextRequest());
}

TEST_CASE("an owner whose keyframes are other ones than they were makes it begin anew") {
  KeyframeAnswers answers = MakeAnswers(11);
  keyframe_t message = Tell(8, -1);
  answers.Answer(message);
  REQUIRE(answers.graph().size() == 11);  // the same
  SECTION("of another time") { ++message.utime; }
  SECTION("after another motion") { message.T_previous_this.x_m += 1e-9; }
  SECTION("with other rays") { message.range_m[3] += 0.001f; }
  CHECK(answers.Answer(message).empty());
  CHECK(BeginsAnew(answers));
}

TEST_CASE("a trajectory goes on from the last keyframe of the one before: what is lacking there is asked for") {
  const auto TellOf = [](KeyframeId id, KeyframeId previous) {
    return ToMessage(Drive()[IndexOf(id)], {kEpoch, id, previous});
  };
  KeyframeAnswers answers = MakeAnswers(11);
  SECTION("the end of the first") {
    CHECK(answers.Answer(TellOf({1, 0}, {0, 11})).empty());
    const auto request = answers.NextRequest();
    REQUIRE(request);
    CHECK(FromOptional(request->after) == Nth(10));
    answers.Answer(Tell(11, -1));
    CHECK(answers.Answer(TellOf({1, 0}, {0, 11})).size() == 1);
    CHECK(answers.graph().newest() == KeyframeId{1, 0});
    CHECK_FALSE(answers.NextRequest());
  }
  SECTION("the begin of the second") {
    CHECK(answers.Answer(TellOf({1, 1}, {1, 0})).empty());
    CHECK(answers.NextRequest());
    answers.Answer(TellOf({1, 0}, {0, 10}));
    CHECK_FALSE(answers.Answer(TellOf({1, 1}, {1, 0})).empty());
    CHECK(answers.graph().size() == 13);
  }
  SECTION("where the first has ended earlier, it is the map of another drive") {
    CHECK(answers.Answer(TellOf({1, 0}, {0, 9})).empty());
    CHECK(answers.graph().size() == 0);
  }
  SECTION("a number that the first does not have any more is one of another drive, too") {
    answers.Answer(TellOf({1, 0}, {0, 10}));
    CHECK(answers.Answer(Tell(11, -1)).empty());
    CHECK(answers.graph().size() == 0);
  }
}

TEST_CASE("a keyframe with a constraint to one that is not there is not taken") {
  KeyframeAnswers answers = MakeAnswers(11);
  Keyframe keyframe = Drive()[11];
  keyframe.constraint = ProximityConstraint{{0, 11}, {}};
  CHECK(answers.Answer(ToMessage(keyframe, {kEpoch, {1, 0}, Nth(10)})).empty());
  CHECK(answers.graph().size() == 11);
  keyframe.constraint = ProximityConstraint{{0, 10}, {}};
  CHECK(answers.Answer(ToMessage(keyframe, {kEpoch, {1, 0}, Nth(10)})).size() == 1);
}

TEST_CASE("an owner that has updates which were not found here is another loop closer's") {
  KeyframeAnswers answers = BeforeFirstUpdate();
  const int k = Updates()[0].keyframe.number;
  CHECK_FALSE(answers.is_of_another_closer());
  CHECK(answers.Answer(Tell(k, k - 2)).empty());
  CHECK(answers.is_of_another_closer());
  answers.Answer(Tell(k + 1, k));
  CHECK_FALSE(answers.is_of_another_closer());
}

}  // namespace crsm
