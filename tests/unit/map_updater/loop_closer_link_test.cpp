#include "services/map_updater/loop_closer_link.hpp"

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "common/graph/default_loop_closer.hpp"
#include "graph/block.hpp"
#include "graph/nth.hpp"
#include "services/stages/keyframe_answers.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

using Clock = LoopCloserLink::Clock;
using std::chrono::milliseconds;

constexpr LoopParameters kLoops{true, 40.0};
const int kLag = GraphConstants{}.lag;
constexpr std::int64_t kEpoch = 7;

/// Every scan becomes a keyframe.
UpdateParameters Drawing() {
  UpdateParameters drawing = TestParameters().update;
  drawing.update_distance_m = 0.1;
  return drawing;
}

/// The map's owner: its mapper and its link, the messages that it sends and the updates that it keeps.
class Owner {
 public:
  Owner() { link.SetEpoch(kEpoch); }

  /// The next scan is matched, that far on from the last one, drawn, and told.
  void Drive(const Pose2& motion, const ValidRays& rays) {
    const auto utime = static_cast<std::int64_t>(mapper.graph().size());
    T_map_laser_ = T_map_laser_ * motion;
    const CriticalRays scan{utime, rays, {}};
    const Mapper::Step step =
        mapper.Integrate(&scan, {utime, T_map_laser_, 0.9, 1, 1, 0, utime == 0 ? MatchState::kFirst : MatchState::kOk});
    REQUIRE(step.keyframe);
    if (step.after.T_new_old) T_map_laser_ = *step.after.T_new_old * T_map_laser_;
    link.SendNewest(now);
  }

  /// Straight on, with hardly anything to see.
  void DriveOn(int num_keyframes) {
    const ValidRays rays{{-1.0f, 0.0f, 1.0f}, {2.0f, 2.0f, 2.0f}};
    for (int i = 0; i < num_keyframes; ++i) Drive({mapper.graph().size() == 0 ? 0.0 : 0.5, 0.0, 0.0}, rays);
  }

  void Hear(const std::vector<pose_graph_t>& messages) {
    for (const pose_graph_t& message : messages) link.Take(message, now);
  }

  /// How often the newest keyframe is sent again within some time in which nobody answers.
  int CountResends(Clock::duration time) {
    const std::size_t before = sent.size();
    for (const auto end = now + time; now < end; now += milliseconds(1)) link.Poll(now);
    return static_cast<int>(sent.size() - before);
  }

  std::int64_t Counter(const std::string& name) const {
    const auto found = counters.counts().find(name);
    return found == counters.counts().end() ? 0 : found->second;
  }

  Clock::time_point now = Clock::time_point() + std::chrono::hours(1);
  Counters counters;
  Mapper mapper{Drawing(), kLoops};
  std::vector<keyframe_t> sent;
  std::vector<GraphUpdate> kept;
  std::vector<KeyframeId> kept_searched;
  LoopCloserLink link{mapper,
                      counters,
                      {[this](const keyframe_t& message) { sent.push_back(message); },
                       [this](const GraphUpdate& update) { kept.push_back(update); },
                       [this](KeyframeId keyframe) { kept_searched.push_back(keyframe); }}};

 private:
  Pose2 T_map_laser_;
};

/// All keyframes up to one are moved; with a thousand and more of them in several messages.
GraphUpdate MoveAll(const Owner& owner, int keyframe, double by_m, int previous = -1) {
  GraphUpdate update;
  update.keyframe = Nth(keyframe);
  update.previous = NthOrNone(previous);
  PoseStretch& moved = update.moved.emplace_back();
  for (int k = 0; k <= keyframe; ++k) moved.poses.push_back(Pose2{by_m, 0.0, 0.0} * owner.mapper.graph().pose(Nth(k)));
  return update;
}

std::vector<pose_graph_t> PartsOf(const GraphUpdate& update) {
  return MakeParts(update, update.keyframe.number, kEpoch);
}

pose_graph_t Unchanged(int keyframe, int previous = -1) {
  return MakeUnchanged(Nth(keyframe), NthOrNone(previous), keyframe, kEpoch);
}

constexpr int kLongDrive = 2501;  // keyframes: an update of all of them has three parts

/// A drive round a block and on, with its drift: loops are closed.
const std::vector<Keyframe>& RoundBlock() {
  static const std::vector<Keyframe> keyframes =
      MakeKeyframes(MakeBlock(7), DriveRoundBlock(5.0, 5.0 + 1.4 * kRoundBlock_m), {0.0, 0.001, 0.0008}, 7);
  return keyframes;
}

void DriveTo(const Keyframe& place, Owner& owner) { owner.Drive(place.T_previous_this, place.rays.Unpack()); }

/// What the loops of that drive bring where nothing comes in between: by the algorithm alone, as in one process.
const std::vector<GraphUpdate>& UpdatesRoundBlock() {
  static const std::vector<GraphUpdate> updates = [] {
    Owner owner;  // of which only the mapper is used
    const auto closer = DefaultLoopCloser(kLoops, Drawing())();
    std::vector<GraphUpdate> found;
    for (const Keyframe& place : RoundBlock()) {
      DriveTo(place, owner);
      const KeyframeGraph& graph = owner.mapper.graph();
      auto update = closer->Add(graph.keyframe(*graph.newest()), {});
      if (!update) continue;
      REQUIRE(owner.mapper.Accept(*update));
      found.push_back(std::move(*update));
    }
    return found;
  }();
  REQUIRE_FALSE(updates.empty());
  return updates;
}

/// Messages on their way: some are lost, some come twice, some later than those behind them.
template <class Message>
class BadNetwork {
 public:
  explicit BadNetwork(std::uint64_t seed) : random_(seed) {}

  void Send(const Message& message) {
    constexpr double kLost = 0.3;
    constexpr double kTwice = 0.3;
    if (random_.Uniform(0.0, 1.0) < kLost) return;
    const int num = random_.Uniform(0.0, 1.0) < kTwice ? 2 : 1;
    for (int i = 0; i < num; ++i) {
      const auto place =
          static_cast<std::ptrdiff_t>(random_.Uniform(0.0, static_cast<double>(under_way_.size()) + 0.999));
      under_way_.insert(under_way_.begin() + place, message);
    }
  }

  std::optional<Message> Receive() {
    if (under_way_.empty()) return std::nullopt;
    Message message = std::move(under_way_.front());
    under_way_.pop_front();
    return message;
  }

 private:
  Random random_;
  std::deque<Message> under_way_;
};

/// The drive round the block over a bad network, with a loop closer that is started anew at some keyframes.
std::vector<GraphUpdate> DriveOverBadNetwork(std::uint64_t seed, const std::vector<int>& restarts) {
  Owner owner;
  KeyframeAnswers closer(DefaultLoopCloser(kLoops, Drawing()));
  BadNetwork<keyframe_t> to_closer(seed);
  BadNetwork<pose_graph_t> to_owner(seed + 1000);
  const auto Exchange = [&] {
    for (const keyframe_t& message : std::exchange(owner.sent, {})) to_closer.Send(message);
    while (const auto message = to_closer.Receive()) {
      for (const pose_graph_t& answer : closer.Answer(*message)) to_owner.Send(answer);
    }
    if (const auto request = closer.NextRequest()) owner.link.Answer(*request, {}, owner.now);
    while (const auto message = to_owner.Receive()) owner.link.Take(*message, owner.now);
    owner.now += milliseconds(100);
    owner.link.Poll(owner.now);
  };
  for (const Keyframe& place : RoundBlock()) {
    DriveTo(place, owner);
    const int newest = owner.mapper.graph().size() - 1;
    if (std::ranges::count(restarts, newest) > 0) closer = KeyframeAnswers(DefaultLoopCloser(kLoops, Drawing()));
    for (int i = 0; !owner.link.IsSettled(); ++i) {
      REQUIRE(i < 2000);
      Exchange();
    }
  }
  CHECK(owner.Counter("pose_graph_refused") == 0);
  return owner.kept;
}

}  // namespace

TEST_CASE(
    "a keyframe is sent again, more and more seldom, until loops were looked for in it; the next ones wait for it") {
  Owner owner;
  owner.DriveOn(1);
  REQUIRE(owner.sent.size() == 1);
  CHECK(FromMessage(owner.sent[0].id) == Nth(0));
  CHECK(owner.sent[0].epoch == kEpoch);
  CHECK_FALSE(FromOptional(owner.sent[0].last_update));
  CHECK_FALSE(owner.link.IsSettled());
  CHECK(owner.CountResends(milliseconds(50)) == 0);
  CHECK(owner.CountResends(milliseconds(2)) == 1);
  CHECK(Encode(owner.sent[1]) == Encode(owner.sent[0]));

  owner.DriveOn(kLag - 1);
  CHECK_FALSE(owner.link.IsReadyForNext());  // keyframe 0 is due
  const int num_resends = owner.CountResends(std::chrono::minutes(1));
  CHECK((num_resends >= 115 && num_resends <= 125));  // every half second at most, after pauses of 50 ms to 0.4 s
  CHECK(owner.Counter("keyframes_resent") == 1 + num_resends);
  CHECK(FromMessage(owner.sent.back().id) == Nth(kLag - 1));
  CHECK(owner.link.num_awaited() == kLag);
  owner.Hear({Unchanged(0)});
  CHECK(owner.link.IsReadyForNext());
  CHECK_FALSE(owner.link.IsSettled());
  owner.Hear({Unchanged(kLag - 1)});
  CHECK(owner.link.IsSettled());
  CHECK(owner.CountResends(std::chrono::minutes(1)) == 0);
  CHECK(owner.kept.empty());
}

TEST_CASE("the parts of an update bring it in any order and however often they come, and not without all of them") {
  Owner drive;
  drive.DriveOn(kLongDrive);
  const GraphUpdate update = MoveAll(drive, kLongDrive - 1, 0.5);
  const auto parts = PartsOf(update);
  REQUIRE(parts.size() == 3);
  drive.Hear({parts[2], parts[0], parts[2], parts[0]});
  CHECK(drive.kept.empty());
  CHECK_FALSE(drive.mapper.last_update());
  CHECK_FALSE(drive.link.IsSettled());
  CHECK(drive.CountResends(std::chrono::seconds(1)) > 0);  // so that the rest is said again

  drive.Hear({parts[1]});
  REQUIRE(drive.kept == std::vector{update});
  CHECK(drive.mapper.best_poses()[0] == update.moved[0].poses);
  CHECK(drive.link.IsSettled());
  drive.Hear({parts[0], parts[1], parts[2]});  // late copies
  CHECK(drive.kept.size() == 1);
  CHECK(drive.Counter("pose_graph_refused") == 0);
}

TEST_CASE("what follows an update that was lost is not heard before that one has come") {
  Owner owner;
  owner.DriveOn(20);
  const GraphUpdate lost = MoveAll(owner, 17, 0.5);
  const GraphUpdate next = MoveAll(owner, 19, 0.25, 17);
  owner.Hear(PartsOf(next));
  owner.Hear({Unchanged(19, 17)});
  CHECK(owner.kept.empty());
  CHECK(owner.link.num_awaited() == 20);
  owner.CountResends(std::chrono::seconds(1));
  CHECK_FALSE(FromOptional(owner.sent.back().last_update));  // says what is lacking

  owner.Hear(PartsOf(lost));
  owner.Hear(PartsOf(next));
  CHECK(owner.kept == std::vector{lost, next});
  CHECK(owner.link.IsSettled());
  owner.DriveOn(1);
  CHECK(FromOptional(owner.sent.back().last_update) == Nth(19));
}

TEST_CASE("updates that fit nothing are counted and change nothing") {
  Owner drive;
  drive.DriveOn(kLongDrive);
  const KeyframePoses poses = drive.mapper.best_poses();
  const GraphUpdate update = MoveAll(drive, kLongDrive - 1, 0.5);
  auto parts = PartsOf(update);
  SECTION("with more poses than keyframes") {
    GraphUpdate spoilt = update;
    spoilt.moved[0].first = Nth(1);
    parts = PartsOf(spoilt);
  }
  SECTION("in parts that overlap") { parts[1].moved[0].first.number -= 1; }
  SECTION("in more parts than there are poses") {
    parts.resize(1);
    parts[0].num_parts = MostParts(kLongDrive) + 1;
  }
  drive.Hear(parts);
  CHECK(drive.Counter("pose_graph_refused") == 1);
  CHECK(drive.kept.empty());
  CHECK(drive.mapper.best_poses() == poses);
  CHECK(drive.link.num_awaited() == kLongDrive);
  drive.Hear(PartsOf(update));
  CHECK(drive.kept == std::vector{update});
}

TEST_CASE("what is of another map, or of keyframes that it does not have, is counted and not heard") {
  Owner owner;
  owner.DriveOn(20);
  GraphUpdate update = MoveAll(owner, 19, 0.5);
  owner.Hear(MakeParts(update, 19, kEpoch + 1));
  owner.Hear({MakeUnchanged(Nth(19), std::nullopt, 19, kEpoch + 1), Unchanged(20)});
  update.keyframe = Nth(20);
  update.moved[0].poses.emplace_back();
  owner.Hear(PartsOf(update));
  CHECK(owner.Counter("pose_graph_of_another_map") == 4);
  CHECK(owner.kept.empty());
  CHECK_FALSE(owner.link.IsSettled());
  CHECK(owner.link.num_awaited() == 20);
}

TEST_CASE("what was found is kept, and told to who lacks the keyframe") {
  Owner owner;
  owner.DriveOn(30);
  GraphUpdate update;
  update.keyframe = Nth(17);
  update.finding = LoopFinding{Nth(2), Nth(17), {0.5, 0.25, 0.125}, 0.75};
  owner.Hear(PartsOf(update));
  owner.Hear({Unchanged(20, 17)});
  CHECK(owner.kept == std::vector<GraphUpdate>{update});
  CHECK(owner.kept_searched == std::vector<KeyframeId>{Nth(17), Nth(20)});
  CHECK(owner.mapper.num_layouts() == 0);
  CHECK(owner.link.num_awaited() == 9);
  owner.sent.clear();
  owner.link.Answer({kEpoch, ToMessage(Nth(15)), 6, -1}, {}, owner.now);
  REQUIRE(owner.sent.size() == 6);
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    const auto search = FindSearch(owner.sent[static_cast<std::size_t>(i)]);
    REQUIRE(search.has_value() == (i < 5));
    if (search) CHECK(search->finding == (i == 1 ? update.finding : std::nullopt));
  }
}

TEST_CASE("who lacks keyframes is given those that it asks for and there are, with the last update that is known") {
  Owner owner;
  owner.link.Answer({kEpoch, ToMessage(NthOrNone(-1)), 64, -1}, {}, owner.now);
  CHECK((owner.sent.empty() && owner.link.IsSettled()));  // the map is empty
  owner.DriveOn(30);
  owner.Hear(PartsOf(MoveAll(owner, 25, 0.5)));
  const auto Given = [&](const keyframe_request_t& request) {
    owner.sent.clear();
    owner.link.Answer(request, {}, owner.now);
    return owner.sent.size();
  };
  REQUIRE(Given({kEpoch, ToMessage(Nth(2)), 5, -1}) == 5);
  for (int i = 0; i < 5; ++i) {
    const KeyframeHead head{kEpoch, Nth(3 + i), Nth(2 + i), Nth(25), EarlierSearch{}};
    CHECK(Encode(owner.sent[static_cast<std::size_t>(i)]) ==
          Encode(ToMessage(owner.mapper.graph().keyframe(Nth(3 + i)), head)));
  }
  CHECK(Given({kEpoch, ToMessage(Nth(27)), 64, -1}) == 2);
  REQUIRE(Given({kEpoch, ToMessage(NthOrNone(-1)), 1, -1}) == 1);
  CHECK(FromMessage(owner.sent[0].id) == Nth(0));
  CHECK_FALSE(FromOptional(owner.sent[0].previous));
  CHECK(Given({kEpoch, ToMessage(Nth(29)), 64, -1}) == 0);
  CHECK(Given({kEpoch, ToMessage(Nth(1'000'000'000)), 64, -1}) == 0);
  CHECK(Given({kEpoch, {1'000'000'000, 0}, 64, -1}) == 0);
  CHECK(Given({kEpoch + 1, ToMessage(NthOrNone(-1)), 64, -1}) == 0);
}

TEST_CASE("who asks for keyframes without a pause is not answered more often than is of use") {
  Owner owner;
  owner.DriveOn(2);
  owner.sent.clear();
  for (int i = 0; i < 1000; ++i) owner.link.Answer({kEpoch, ToMessage(Nth(0)), 1, -1}, {1, 2}, owner.now);
  CHECK(std::ssize(owner.sent) == static_cast<std::int64_t>(RequestLimiter::kAtOnce));
  CHECK(owner.Counter("keyframe_requests_refused") == 1000 - std::ssize(owner.sent));
}

TEST_CASE("with messages lost, doubled and in any order, and the loop closer started anew, the same loops are kept") {
  const int at_loop = UpdatesRoundBlock()[0].keyframe.number;
  const std::vector<std::vector<int>> restarts{{}, {20}, {at_loop}, {at_loop + 1, at_loop + 2}, {100, at_loop + 4}};
  for (std::size_t i = 0; i < restarts.size(); ++i) {
    CAPTURE(restarts[i]);
    CHECK(DriveOverBadNetwork(i, restarts[i]) == UpdatesRoundBlock());
  }
}

}  // namespace crsm

#include "services/map_updater/loop_closer_link.cpp"  // in no library: it is map_updater's own
