#include "services/fleet_mapper/robot_link.hpp"

#include "catch.hpp"
#include "graph/block.hpp"
#include "services/fleet_mapper/robot_link.cpp"  // in no library: it is fleet_mapper's own

namespace crsm {
namespace {

using namespace std::chrono_literals;

/// A robot, the fleet that hears it, and a network that loses what a test wants.
struct Robot {
  explicit Robot(std::uint64_t seed = 1)
      : keyframes(MakeKeyframes(MakeBlock(seed), DriveRoundBlock(5.0, 25.0), {}, seed)) {}

  keyframe_t Message(int number, bool searched, std::int64_t epoch = 7) const {
    Keyframe keyframe = keyframes[static_cast<std::size_t>(number)];
    KeyframeHead head{epoch, {0, number}};
    if (number > 0) head.previous = KeyframeId{0, number - 1};
    if (searched) head.search = EarlierSearch{};
    return ToMessage(keyframe, head);
  }

  /// What is complete goes on the common map. How many keyframes those were.
  int TakeAll() {
    int num = 0;
    while (auto told = link.Next(now)) {
      const int map = told->map ? *told->map : fleet.BeginMap();
      fleet.Add(map, FromMessage(told->message), FindSearch(told->message)->finding, {});
      link.Begin(map, told->message.epoch);
      ++num;
    }
    return num;
  }

  void Hear(const keyframe_t& message) { link.Take(message, now, 1); }

  /// As map_updater answers.
  void Answer(const keyframe_request_t& request, int num_keyframes) {
    const auto after = FromOptional(request.after);
    if (request.epoch == 0) return Hear(Message(num_keyframes - 1, true));
    const int first = after ? after->number + 1 : 0;
    for (int i = first; i < std::min(num_keyframes, first + request.num_keyframes); ++i) Hear(Message(i, true));
  }

  /// Questions for places are answered, with those that the robot has.
  std::optional<keyframe_request_t> NextRequest(RobotLink::Clock::time_point at) {
    auto request = link.NextRequest(at);
    if (!request || request->marks_held < 0) return request;
    ++num_asked_for_marks;
    Tell(request->marks_held, at);
    return link.NextRequest(at);
  }

  /// As map_updater does to who holds those of a checksum. What is new of it.
  std::optional<fleet_marks_t> Tell(std::int64_t held, RobotLink::Clock::time_point at) {
    robot_marks_t message = ToMessage(marks, 7);
    if (message.checksum == held) message.num_marks = 0, message.marks.clear();
    auto taken = link.Take(message, at);
    if (taken) new_marks.push_back(*taken);
    return taken;
  }

  std::vector<AnchoredMark> marks;
  std::vector<fleet_marks_t> new_marks;  ///< of all that was told
  int num_asked_for_marks = 0;
  std::vector<Keyframe> keyframes;
  Fleet fleet{{true, 40.0}, UpdateParameters{}};
  RobotLink link{"robot1/", fleet};
  RobotLink::Clock::time_point now = RobotLink::Clock::now();
};

}  // namespace

TEST_CASE("a keyframe waits until its robot's loop closer has said what it found there") {
  Robot robot;
  robot.Hear(robot.Message(0, false));
  CHECK(robot.TakeAll() == 0);
  CHECK(robot.link.waits_for_loop_closer());
  robot.link.Take(MakeUnchanged({0, 0}, {}, 0, 7));
  CHECK(robot.TakeAll() == 1);
  for (int i = 1; i < 5; ++i) robot.Hear(robot.Message(i, false));
  GraphUpdate update;
  update.keyframe = {0, 3};
  update.finding = LoopFinding{{0, 0}, {0, 3}, {}, 0.9};
  robot.link.Take(MakeParts(update, 0, 7).front());
  robot.now += 1s;
  CHECK(robot.link.Next(robot.now)->message.num_findings == 0);
  CHECK(robot.link.Next(robot.now)->message.num_findings == 0);
  CHECK(robot.link.Next(robot.now)->message.num_findings == 1);
  CHECK_FALSE(robot.link.Next(robot.now));                 // of the fourth nothing was said
  robot.link.Take(MakeUnchanged({0, 4}, {{0, 4}}, 0, 7));  // what the update at it has found, was lost
  CHECK_FALSE(robot.link.Next(robot.now));
  robot.link.Take(MakeUnchanged({0, 4}, {{0, 3}}, 0, 7));
  CHECK(robot.link.Next(robot.now)->message.num_findings == 0);
}

TEST_CASE("what was lost is asked for, and nothing else") {
  Robot robot;
  const auto first = robot.NextRequest(robot.now);
  REQUIRE(first);
  CHECK(first->epoch == 0);  // whichever map it has
  CHECK_FALSE(robot.NextRequest(robot.now));
  robot.Answer(*first, 30);
  CHECK(robot.TakeAll() == 0);  // the thirtieth alone
  int num_requests = 0;
  int num_taken = 0;
  while (const auto request = robot.NextRequest(robot.now)) {
    CHECK(request->epoch == 7);
    CHECK(request->num_keyframes <= 8);
    robot.Answer(*request, 30);
    num_taken += robot.TakeAll();
    ++num_requests;
  }
  CHECK(num_taken == 30);
  CHECK(num_requests == 5);  // the first one alone, which tells which map it is, and 29 by eight
  robot.now += 10s;
  CHECK_FALSE(robot.NextRequest(robot.now));
  robot.Hear(robot.Message(32, true));  // two were lost
  const auto request = robot.NextRequest(robot.now);
  REQUIRE(request);
  CHECK(FromOptional(request->after) == KeyframeId{0, 29});
  CHECK_FALSE(robot.NextRequest(robot.now + 100ms));
  CHECK(robot.NextRequest(robot.now + 1s));  // was lost, too
  robot.Answer(*request, 33);
  CHECK(robot.TakeAll() == 3);
}

TEST_CASE("a robot that is silent is asked now and then whether it has gone on") {
  Robot robot;
  for (int i = 0; i < 3; ++i) robot.Hear(robot.Message(i, true));
  CHECK(robot.TakeAll() == 3);
  CHECK_FALSE(robot.NextRequest(robot.now + 29s));
  const auto request = robot.NextRequest(robot.now + 31s);
  REQUIRE(request);
  CHECK(request->epoch == 0);
  CHECK_FALSE(robot.NextRequest(robot.now + 32s));
}

TEST_CASE("the places of a robot are asked for every few seconds, and are new once") {
  Robot robot;
  for (int i = 0; i < 3; ++i) robot.Hear(robot.Message(i, true));
  CHECK(robot.TakeAll() == 3);
  CHECK_FALSE(robot.NextRequest(robot.now));
  CHECK(robot.num_asked_for_marks == 1);
  CHECK(robot.new_marks.empty());  // it has none
  CHECK(robot.link.HasToldMarks(robot.now));
  robot.marks = {{{5, "v", "victim", "", 1, {0.25, 0.0, 0.25}, false, {}}, {{{0, 2}, {1.5, 0.5}}}}};
  CHECK_FALSE(robot.NextRequest(robot.now + 4s));
  CHECK(robot.new_marks.empty());
  CHECK_FALSE(robot.link.HasToldMarks(robot.now + 4s));  // who wants all has them asked for at once
  CHECK_FALSE(robot.NextRequest(robot.now + 4s));
  CHECK(robot.link.HasToldMarks(robot.now + 4s));
  REQUIRE(robot.new_marks.size() == 1);
  CHECK(robot.new_marks[0].map == 0);
  CHECK(FromMessage(robot.new_marks[0].marks) == robot.marks);
  for (int i = 1; i <= 5; ++i) CHECK_FALSE(robot.NextRequest(robot.now + i * 5s + 1s));
  CHECK(robot.new_marks.size() == 1);
  SECTION("those at a keyframe that is not there yet are asked for again") {
    robot.marks[0].points[0].keyframe.number = 3;
    CHECK_FALSE(robot.Tell(0, robot.now + 50s));
    CHECK_FALSE(robot.link.HasToldMarks(robot.now + 50s));
    robot.Hear(robot.Message(3, true));
    CHECK(robot.TakeAll() == 1);
    CHECK(robot.Tell(0, robot.now + 51s));
  }
  SECTION("a robot that has removed its last place has none") {
    robot.marks.clear();
    const auto taken = robot.Tell(robot.new_marks[0].marks.checksum, robot.now + 50s);
    REQUIRE(taken);
    CHECK(taken->marks.num_marks == 0);
  }
  SECTION("an answer to somebody else, who holds others, tells nothing") {
    robot.marks[0].mark.name = "door";
    CHECK_FALSE(robot.Tell(ToMessage(robot.marks, 7).checksum, robot.now + 50s));
  }
  SECTION("those of an earlier session are not new") {
    Robot again;
    for (int i = 0; i < 3; ++i) again.Hear(again.Message(i, true));
    CHECK(again.TakeAll() == 3);
    again.link.Hold(robot.new_marks[0]);
    again.marks = robot.marks;
    CHECK_FALSE(again.NextRequest(again.now));
    CHECK(again.num_asked_for_marks == 1);
    CHECK(again.new_marks.empty());
  }
}

TEST_CASE("a robot whose host was started again goes on with its map, and one that begins anew has another") {
  Robot robot;
  for (int i = 0; i < 10; ++i) robot.Hear(robot.Message(i, true));
  CHECK(robot.TakeAll() == 10);
  SECTION("the same map, as of another boot") {
    robot.Hear(robot.Message(11, true, 8));
    const auto request = robot.NextRequest(robot.now);
    REQUIRE(request);
    CHECK(FromOptional(request->after) == std::nullopt);
    robot.Hear(robot.Message(0, true, 8));
    robot.Hear(robot.Message(10, true, 8));
    CHECK(robot.TakeAll() == 2);
    CHECK(robot.fleet.num_maps() == 1);
    robot.Hear(robot.Message(12, true, 7));  // late, of before
    CHECK(robot.TakeAll() == 0);
    CHECK(robot.link.epoch() == 8);
  }
  SECTION("another map") {
    Robot other(4);
    for (int i = 0; i < 4; ++i) robot.Hear(other.Message(i, true, 9));
    CHECK(robot.TakeAll() == 4);
    CHECK(robot.fleet.num_maps() == 2);
    CHECK(robot.link.maps() == std::vector{0, 1});
  }
  SECTION("the same map, of which a power cut took the end") {
    robot.Hear(robot.Message(0, true, 8));
    Robot other(4);
    keyframe_t changed = other.Message(5, true, 8);
    robot.Hear(changed);
    CHECK(robot.TakeAll() == 0);
    const auto request = robot.NextRequest(robot.now);
    REQUIRE(request);
    CHECK(FromOptional(request->after) == std::nullopt);
  }
}

TEST_CASE("on a network that loses a fifth of all messages, and is away for a minute, no keyframe is lost") {
  Robot robot;
  Random random(5);
  int num_there = 0;
  int num_taken = 0;
  int num_sent = 0;
  for (int tick = 0; num_taken < std::ssize(robot.keyframes); ++tick) {
    REQUIRE(tick < 5000);
    robot.now += 100ms;
    const auto Passes = [&] {
      ++num_sent;
      const bool is_away = tick >= 100 && tick < 700;
      return !is_away && random.Uniform(0.0, 1.0) > 0.2;
    };
    if (tick % 6 == 0 && num_there < std::ssize(robot.keyframes)) {  // one is drawn every 0.6 s
      if (Passes()) robot.Hear(robot.Message(num_there, false));
      const auto previous = num_there > 0 ? std::optional(KeyframeId{0, num_there - 1}) : std::nullopt;
      if (Passes()) robot.link.Take(MakeUnchanged({0, num_there}, previous, 0, 7));
      ++num_there;
    }
    if (const auto request = robot.NextRequest(robot.now); request && Passes()) {
      const auto after = FromOptional(request->after);
      const int first = request->epoch == 0 ? num_there - 1 : (after ? after->number + 1 : 0);
      const int end = request->epoch == 0 ? num_there : std::min(num_there, first + request->num_keyframes);
      for (int i = first; i < end; ++i) {
        if (Passes()) robot.Hear(robot.Message(i, true));
      }
    }
    num_taken += robot.TakeAll();
  }
  CHECK(num_taken == std::ssize(robot.keyframes));
  CHECK(num_sent < 8 * num_taken);  // two each, and what was asked for
}

TEST_CASE("of keyframes that come without those before them no more wait than there is room for, and the first stay") {
  Robot robot;
  robot.Hear(robot.Message(0, true));
  for (int i = 2; i < 1000; ++i) {
    keyframe_t message = robot.Message(2, true);
    message.id.number = i;
    message.previous.number = i - 1;
    robot.Hear(message);
  }
  CHECK(robot.TakeAll() == 1);
  robot.Hear(robot.Message(1, true));
  CHECK(robot.TakeAll() == static_cast<int>(RobotLink::kMostWaiting));
  CHECK(robot.link.is_behind());
}

}  // namespace crsm
