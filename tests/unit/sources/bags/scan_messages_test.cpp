#include "services/sources/bags/scan_messages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "transform_bytes.hpp"

namespace crsm {
namespace {

const BagTopic kRos1{"/scan", "sensor_msgs/LaserScan", "ros1"};
const BagTopic kCdr{"/scan", "sensor_msgs/msg/LaserScan", "cdr"};
const BagTopic kJson{"/scan", "foxglove.LaserScan", "json"};

/// Of both encodings, which must agree.
DecodedScan DecodeBoth(const LaserMessage& message) {
  const DecodedScan ros1 = DecodeScan(kRos1, message.Ros1());
  const DecodedScan cdr = DecodeScan(kCdr, message.Cdr());
  REQUIRE(ros1.scan.has_value() == cdr.scan.has_value());
  CHECK(ros1.refusal == cdr.refusal);
  if (ros1.scan) CHECK(*ros1.scan == *cdr.scan);
  return cdr;
}

LaserScan ScanOf(const LaserMessage& message) {
  const DecodedScan decoded = DecodeBoth(message);
  REQUIRE(decoded.scan);
  return *decoded.scan;
}

std::string RefusalOf(const LaserMessage& message) { return DecodeBoth(message).refusal; }

std::string Json(const std::string& ranges, const std::string& rest = R"("start_angle": -1, "end_angle": 1)") {
  return R"({"timestamp": {"sec": 100, "nsec": 7000}, "frame_id": "laser", )" + rest + R"(, "ranges": )" + ranges + "}";
}

const BagTopic kOdometry{"/odom", "nav_msgs/Odometry", "ros1"};

}  // namespace

TEST_CASE("a LaserScan of ROS is a scan as it was measured") {
  CHECK(ScanOf({}) == LaserScan{100'000'000, -1.0f, 0.5f, {1.0f, 2.0f, 3.0f}});
}

TEST_CASE("the stamp of a LaserScan is that of its first beam, the utime that of its last; each beam has its time") {
  const LaserScan scan = ScanOf({.nanosec = 1'000'600, .time_increment = 0.25f});
  CHECK(scan.utime == 100'501'001);  // 1000.6 us and twice 0.25 s later, rounded
  CHECK(scan.times_s == std::vector<float>{-0.5f, -0.25f, 0.0f});
  const LaserScan turned = ScanOf({.time_increment = -0.25f});  // its driver has measured the first beam last
  CHECK(turned.utime == 100'000'000);
  CHECK(turned.times_s == std::vector<float>{0.0f, -0.25f, -0.5f});
  for (const float cannot_be : {NAN, INFINITY, 0.51f, 1000.0f}) {  // more than a second is no sweep
    CHECK(ScanOf({.time_increment = cannot_be}).utime == 100'000'000);
    CHECK(ScanOf({.time_increment = cannot_be}).times_s.empty());
  }
}

TEST_CASE("where the times of a LaserScan are not believed, its utime is the stamp and the sweep, either way round") {
  ScanParameters parameters;
  parameters.beam_times = false;
  for (const auto& [sweep_s, utime] : {std::pair(0.1, 100'100'000), {-0.1, 100'100'000}, {0.0, 100'000'000}}) {
    parameters.sweep_s = sweep_s;
    const auto scan = DecodeScan(kCdr, LaserMessage{.time_increment = 0.25f}.Cdr(), parameters).scan;
    REQUIRE(scan);
    CHECK(scan->utime == utime);
    CHECK(scan->times_s.empty());
  }
}

TEST_CASE("clockwise scans stay clockwise") { CHECK(ScanOf({.angle_increment = -0.5f}).angle_step_rad == -0.5f); }

TEST_CASE("what is outside of a laser's range is no return") {
  const float inf = std::numeric_limits<float>::infinity();
  const LaserMessage message{.range_min = 0.5f,
                             .ranges = {0.4f, 0.5f, 9.9f, 10.0f, 10.1f, inf, -inf, NAN, 0.0f, -1.0f}};
  CHECK(ScanOf(message).ranges_m == std::vector<float>{0.0f, 0.5f, 9.9f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f});
}

TEST_CASE("a laser that does not know its range has any") {
  for (const auto& [least_m, most_m] :
       {std::pair(0.0f, 0.0f), {NAN, NAN}, {5.0f, 5.0f}, {0.0f, NAN}, {9.0f, -1.0f}, {0.0f, INFINITY}}) {
    const LaserMessage message{.range_min = least_m, .range_max = most_m, .ranges = {0.01f, 500.0f}};
    CHECK(ScanOf(message).ranges_m == message.ranges);
  }
}

TEST_CASE("scans have 2 to 65536 beams") {
  const auto with = [](std::size_t count) {
    return LaserMessage{.angle_increment = 0.001f, .ranges = std::vector<float>(count, 1.0f)};
  };
  for (const std::size_t count : {2u, 4096u}) CHECK(ScanOf(with(count)).ranges_m.size() == count);
  for (const std::size_t count : {0u, 1u, 65537u}) {
    CHECK(RefusalOf(with(count)) == "scans have " + std::to_string(count) + " ranges: they must have 2 to 65536");
  }
}

TEST_CASE("of more than 4096 beams every second is used, each with its own angle and time") {
  LaserMessage message{.angle_min = -0.75f, .angle_increment = 0.0001f, .time_increment = 0.0001f, .ranges = {}};
  for (int i = 0; i < 5520; ++i) message.ranges.push_back(1.0f + 0.001f * static_cast<float>(i));
  const DecodedScan decoded = DecodeScan(kCdr, message.Cdr());
  REQUIRE(decoded.scan);
  REQUIRE(decoded.scan->ranges_m.size() == 2760);
  REQUIRE(decoded.scan->times_s.size() == 2760);
  CHECK(decoded.thinned == "scans have 5520 beams, of which one in 2 is used, because 4096 are the most");
  for (const std::size_t beam : {0u, 1u, 2759u}) {
    const float original = 2.0f * static_cast<float>(beam);
    CHECK(decoded.scan->ranges_m[beam] == message.ranges[2 * beam]);
    CHECK(decoded.scan->angle_min_rad + static_cast<float>(beam) * decoded.scan->angle_step_rad ==
          Approx(-0.75f + 0.0001f * original));
    CHECK(decoded.scan->times_s[beam] == Approx(0.0001f * (original - 5519.0f)).margin(1e-6));
  }
}

TEST_CASE("a header whose angle_max and angle_increment tell opposite senses is named, and angle_increment counts") {
  const auto ContradictionIn = [](float from, float to, float increment, std::size_t num_beams) {
    const DecodedScan decoded = DecodeScan(kCdr, LaserMessage{.angle_min = from,
                                                              .angle_increment = increment,
                                                              .angle_max = to,
                                                              .ranges = std::vector<float>(num_beams, 1.0f)}
                                                     .Cdr());
    REQUIRE(decoded.scan);
    CHECK(decoded.scan->angle_step_rad == increment);
    return decoded.contradiction;
  };
  CHECK(
      ContradictionIn(-1.5f, 1.5f, -0.5f, 7) ==
      "headers contradict themselves: angle_increment is -0.5000 rad, but angle_max 1.5000 rad is more than angle_min "
      "-1.5000 rad: angle_increment counts; if the map is a mirror image, --mirrored turns the scans round");
  CHECK(ContradictionIn(1.5f, -1.5f, 0.5f, 7).find("is less than angle_min 1.5000 rad") != std::string::npos);
  CHECK(ContradictionIn(-3.0f, 3.0f, -0.5f, 12) != "");  // of a full turn, with the beam behind the last one
  CHECK(ContradictionIn(-1.5f, 1.5f, 0.5f, 7) == "");
  CHECK(ContradictionIn(1.5f, -1.5f, -0.5f, 7) == "");
  CHECK(ContradictionIn(3.0f, -3.0f, 0.05f, 7) == "");  // the view leads through pi
  CHECK(ContradictionIn(-1.0f, 0.0f, 0.5f, 7) == "");
  CHECK(ContradictionIn(1.0f, 1.0f, -0.5f, 3) == "");  // angle_max tells nothing
}

TEST_CASE("a scan whose angles or stamp cannot be is refused, with the reason") {
  CHECK(RefusalOf({.angle_increment = 0.0f}).find("radstep must not be 0") != std::string::npos);
  CHECK(RefusalOf({.angle_min = NAN}).find("must be finite") != std::string::npos);
  CHECK(RefusalOf({.angle_min = -90.0f, .angle_increment = 1.0f}).find("degrees") != std::string::npos);
  CHECK(RefusalOf({.nanosec = 1'000'000'000}).ends_with("it must be the time since 1970"));
  const LaserMessage before_1970{.sec = 0x80000000u};
  CHECK_FALSE(DecodeScan(kCdr, before_1970.Cdr()).scan);
  CHECK(DecodeScan(kRos1, before_1970.Ros1()).scan->utime == 2'147'483'648'000'000);  // ROS 1 counts to 2106
}

TEST_CASE("a LaserScan that is cut anywhere is refused, and so is one with more behind it") {
  const auto is_refused = [](const BagTopic& topic, const std::string& bytes) {
    return DecodeScan(topic, bytes).refusal == "messages are cut short, or do not match their type";
  };
  for (const auto& [topic, bytes] : {std::pair(kRos1, LaserMessage().Ros1()), std::pair(kCdr, LaserMessage().Cdr())}) {
    for (std::size_t size = 0; size < bytes.size(); ++size) CHECK(is_refused(topic, bytes.substr(0, size)));
    CHECK(is_refused(topic, bytes + std::string(8, '\0')));
  }
  CHECK(is_refused(kRos1, LaserMessage().Ros1() + '\0'));
  CHECK(DecodeScan(kCdr, LaserMessage().Cdr() + std::string(3, '\0')).scan);  // DDS fills up to whole words
}

TEST_CASE("a count of ranges that is a lie is refused") {
  const LaserMessage message;
  std::string good = message.Ros1();
  const std::size_t count_at = good.size() - 4 * (message.ranges.size() + 2);  // ranges and intensities follow it
  REQUIRE(good.substr(count_at, 4) == Little(3u));
  for (const std::uint32_t lie : {0x7fffffffu, 0xffffffffu, 0x40000003u}) {
    CHECK_FALSE(DecodeScan(kRos1, good.replace(count_at, 4, Little(lie))).scan);
  }
}

TEST_CASE("CDR with the high byte first is read, CDR that is not plain is refused") {
  const std::string little = LaserMessage().Cdr();
  std::string big("\0\0\0\0", 4);
  for (std::size_t at = 4; at < little.size(); at += 4) {
    const bool is_frame = at == 16;
    const std::string word = little.substr(at, 4);
    big += is_frame ? word : std::string(word.rbegin(), word.rend());
  }
  REQUIRE(DecodeScan(kCdr, big).scan);
  CHECK(DecodeScan(kCdr, big).scan == DecodeScan(kCdr, little).scan);
  CHECK_FALSE(DecodeScan(kCdr, std::string("\0\3\0\0", 4) + little.substr(4)).scan);  // a list of parameters
}

TEST_CASE("numbers in CDR stand at multiples of their size, behind a frame of any length") {
  for (const std::string frame : {"", "a", "ab", "abc", "abcd"}) {
    const std::string padding((4 - (frame.size() + 1) % 4) % 4, '\0');
    const LaserMessage message{.frame = frame};
    const std::string bytes = std::string("\0\1\0\0", 4) + Little(message.sec) + Little(message.nanosec) +
                              Text(frame + '\0') + padding + message.Floats();
    REQUIRE(DecodeScan(kCdr, bytes).scan);
    CHECK(DecodeScan(kCdr, bytes).scan == ScanOf({}));
  }
}

TEST_CASE("a foxglove.LaserScan in JSON is a sweep from its start to its end") {
  const auto decoded = DecodeScan(kJson, Json(R"([1, 2.5, null, "NaN", 1e300])"));
  REQUIRE(decoded.scan);
  CHECK(decoded.scan == LaserScan{100'000'007, -1.0f, 0.5f, {1.0f, 2.5f, 0.0f, 0.0f, 0.0f}});
}

TEST_CASE("JSON that is no LaserScan is refused") {
  for (const std::string& text :
       {std::string(), std::string("[]"), std::string("{}"), Json("3"), Json("[true, 1]"), Json("[1, 2]").substr(1),
        Json("[1, 2]", R"("start_angle": "a", "end_angle": 1)"), Json("[1, 2]", R"("start_angle": 0)"),
        Json("[1, 2]", R"("start_angle": -1e300, "end_angle": 1)"), std::string(R"({"timestamp": 5})"),
        std::string(R"({"timestamp": {"sec": -1, "nsec": 0}, "start_angle": 0, "end_angle": 1, "ranges": [1, 1]})")}) {
    CHECK(DecodeScan(kJson, text).refusal == "messages are cut short, or do not match their type");
  }
  const std::string deep(kMostMessageBytes, '[');
  CHECK_FALSE(DecodeScan(kJson, deep).scan);
  CHECK(DecodeScan(kJson, Json("[]")).refusal == "scans have 0 ranges: they must have 2 to 65536");
}

TEST_CASE("odometry is the robot's place and heading in the plane; that without an orientation is none") {
  const double half = std::sqrt(0.5);
  const auto odometry = DecodeOdometry(
      kOdometry, Ros1Odometry({.x_m = 1.5, .y_m = -2.0, .rotation = {0, 0, half, half}, .nanosec = 2000}));
  REQUIRE(odometry);
  CHECK(odometry->sample.utime == 100'000'002);
  CHECK(odometry->sample.T_odom_robot == Pose2{1.5, -2.0, 1.570796});  // whole microradians
  CHECK(DecodeOdometry(kOdometry, Ros1Odometry({.rotation = {0, 0, 0, 0}}))->sample.T_odom_robot == std::nullopt);
}

TEST_CASE("odometry that is none is refused") {
  const std::string good = Ros1Odometry({});
  REQUIRE(DecodeOdometry(kOdometry, good));
  for (std::size_t size = 0; size < good.size(); ++size) CHECK_FALSE(DecodeOdometry(kOdometry, good.substr(0, size)));
  CHECK_FALSE(DecodeOdometry(kOdometry, good + '\0'));
  for (const TransformFields& bad : {TransformFields{.x_m = NAN}, TransformFields{.rotation = {0, 0, 0, 2}},
                                     TransformFields{.nanosec = 1'000'000'000}}) {
    CHECK_FALSE(DecodeOdometry(kOdometry, Ros1Odometry(bad)));
  }
}

}  // namespace crsm
