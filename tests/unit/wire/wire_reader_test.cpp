#include "services/wire/wire_reader.hpp"

#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <wire_fields/botlab/lidar_nranges_t.hpp>
#include <wire_fields/botlab/lidar_t.hpp>
#include <wire_fields/mbot_lcm_msgs/pose2D_t.hpp>
#include <wire_fields/sensor_msgs/LaserScan.hpp>

#include "catch.hpp"
#include "count_finder.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

/// Fills messages with any numbers, and with strings and arrays of 0 to 4 elements.
class RandomFiller {
 public:
  template <class Message>
  Message Make() {
    Message message{};
    Counts counts;
    FieldsOf<Message>::Visit([&](const auto& field) { FillField(message, field, counts); });
    return message;
  }

 private:
  using Counts = std::set<const void*>;  ///< members of the message that are the count of an array filled so far

  template <class Message, class Value>
  void FillField(Message& message, Value Message::*member, Counts&) {
    FillValue(message.*member);
  }

  /// The first array of a count says how many.
  template <class Message, class Element, class Count>
  void FillField(Message& message, const ArrayField<Message, Element, Count>& array, Counts& counts) {
    Count& count = message.*array.count;
    if (counts.insert(&count).second) count = static_cast<Count>(random_() % std::min<std::size_t>(5, array.most + 1));
    (message.*array.elements).resize(static_cast<std::size_t>(count));
    for (Element& element : message.*array.elements) FillValue(element);
  }

  template <class Value>
  void FillValue(Value& value) {
    if constexpr (std::is_arithmetic_v<Value>) {
      value = static_cast<Value>(random_());
    } else if constexpr (std::is_array_v<Value>) {
      for (auto& element : value) FillValue(element);
    } else if constexpr (std::is_same_v<Value, std::string>) {
      value.assign(random_() % 5, 'x');
    } else {
      value = Make<Value>();
    }
  }

  std::mt19937_64 random_{1};
};

template <class Message>
void CheckHostileCounts(const Message& message, const Bytes& bytes) {
  constexpr auto kLargest = std::numeric_limits<std::int32_t>::max();
  CountFinder finder;
  finder.Visit(message);
  for (const auto& [at, count] : finder.counts()) {
    CAPTURE(at, count);
    REQUIRE(ReadCount(bytes, at) == count);
    for (const std::int32_t hostile : {count + 1, count - 1, -1, -kLargest - 1, kLargest, 1 << 30, 1 << 29, 1000000}) {
      CAPTURE(hostile);
      CHECK_FALSE(CountsFit<Message>(WithCount(bytes, at, hostile)));
    }
  }
}

template <class Message>
void CheckType() {
  CAPTURE(Message::getTypeName());
  RandomFiller filler;
  for (int i = 0; i < 20; ++i) {
    const auto message = filler.Make<Message>();
    const Bytes bytes = Encode(message);
    CHECK(CountsFit<Message>(bytes));
    Bytes longer = bytes;
    longer.push_back(0);
    CHECK_FALSE(CountsFit<Message>(longer));
    for (std::size_t size = 0; size < bytes.size(); ++size) {  // a copy, so that reading beyond it is an error
      CAPTURE(size);
      CHECK_FALSE(CountsFit<Message>(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))));
    }
    CheckHostileCounts(message, bytes);
  }
}

template <class... Messages>
void CheckTypes() {
  (CheckType<Messages>(), ...);
}

}  // namespace

TEST_CASE(
    "what lcm-gen writes of any message is walked over whole; cut, lengthened or counted wrongly, it is refused") {
  CheckTypes<bot_core::planar_lidar_t, botlab::lidar_t, botlab::lidar_nranges_t, sensor_msgs::LaserScan, sweep_t>();
  CheckTypes<bot_core::pose_t, mbot_lcm_msgs::pose2D_t, critical_rays_t, scan_match_t, map_delta_t, map_page_t>();
  CheckTypes<map_request_t, scan_request_t, scan_answer_t, keyframe_t, keyframe_request_t, pose_graph_t>();
  CheckTypes<service_status_t, journal_head_t, journal_check_t>();
  CheckTypes<fleet_pose_t, fleet_keyframe_t, changes_t, mark_t, kept_mark_t, robot_marks_t, fleet_marks_t>();
}

TEST_CASE("an array has the most elements that are allowed, and not one more although its bytes are there") {
  map_tile_t tile{};
  for (const std::size_t size : {4100u, 4101u}) {
    tile.runs.resize(size);
    tile.num_bytes = static_cast<std::int32_t>(size);
    CHECK(CountsFit<map_tile_t>(Encode(tile)) == (size == 4100));
  }
  service_status_t status{};
  for (const std::size_t size : {64u, 65u}) {
    status.counter_name.resize(size);
    status.counter_value.resize(size);
    status.num_counters = static_cast<std::int32_t>(size);
    CHECK(CountsFit<service_status_t>(Encode(status)) == (size == 64));
  }
}

TEST_CASE("a string has 1023 letters at most, and a NUL at its end") {
  service_status_t status{};
  for (const std::size_t size : {1023u, 1024u}) {
    status.name.assign(size, 'x');
    CHECK(CountsFit<service_status_t>(Encode(status)) == (size == 1023));
  }
  status.name.clear();
  const Bytes bytes = Encode(status);
  REQUIRE(ReadCount(bytes, 16) == 1);
  Bytes without_nul = WithCount(bytes, 16, 0);
  without_nul.erase(without_nul.begin() + 20);
  CHECK_FALSE(CountsFit<service_status_t>(without_nul));
}

}  // namespace crsm
