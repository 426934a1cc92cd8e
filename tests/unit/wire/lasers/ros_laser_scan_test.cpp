#include <limits>
#include <sensor_msgs/LaserScan.hpp>

#include "catch.hpp"
#include "services/wire/laser_types.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

sensor_msgs::LaserScan RosScan() {
  sensor_msgs::LaserScan scan{};
  scan.header = {7, {100, 250'000'900}, "laser"};
  scan.angle_min = -0.5f;
  scan.angle_max = 0.25f;
  scan.angle_increment = 0.25f;
  scan.range_min = 0.5f;
  scan.range_max = 10.0f;
  scan.ranges = {0.5f, 0.25f, 11.0f, 10.0f};
  scan.ranges_length = 4;
  return scan;
}

std::optional<LaserScan> Read(const sensor_msgs::LaserScan& scan) {
  auto reading = DecodeLaser(Encode(scan), {});
  return reading ? std::optional(reading->scan) : std::nullopt;
}

template <class Change>
bool IsRead(Change change) {
  sensor_msgs::LaserScan scan = RosScan();
  change(scan);
  return Read(scan).has_value();
}

}  // namespace

TEST_CASE("a scan of ROS is found by the fingerprint that dimos has, and named") {
  const LaserType* type = FindLaserType(std::uint64_t{0x8de5754e00f25f00});  // of dimos's own Python types
  REQUIRE(type);
  CHECK(type->name == "sensor_msgs.LaserScan");
}

TEST_CASE("a scan of ROS says whose it is and what in it contradicts itself, and more than 4096 beams are thinned") {
  sensor_msgs::LaserScan message = RosScan();
  message.ranges.assign(5520, 1.0f);
  message.ranges_length = 5520;
  message.angle_increment = 0.001f;
  const auto reading = DecodeLaser(Encode(message), {});
  REQUIRE(reading);
  CHECK(reading->frame == "laser");
  CHECK(reading->scan.ranges_m.size() == 2760);
  CHECK(reading->scan.angle_step_rad == 0.002f);
  CHECK(reading->thinned == "scans have 5520 beams, of which one in 2 is used, because 4096 are the most");
  CHECK(DecodeLaser(Encode(RosScan()), {})->thinned.empty());
  message.angle_min = 2.75f;
  message.angle_max = 2.75f - 5.519f;
  const std::string contradiction = DecodeLaser(Encode(message), {})->contradiction;
  CHECK(
      contradiction.starts_with("headers contradict themselves: angle_increment is 0.0010 rad, but angle_max -2.7690"));
  CHECK(DecodeLaser(Encode(RosScan()), {})->contradiction.empty());
}

TEST_CASE("a scan of ROS has its stamp as utime, and no return where a range is at its upper limit or beyond") {
  const auto scan = Read(RosScan());
  REQUIRE(scan);
  CHECK(*scan == LaserScan{100'250'001, -0.5f, 0.25f, {0.5f, 0.0f, 0.0f, 0.0f}});
}

TEST_CASE("a scan of ROS without limits keeps its ranges") {
  for (const auto& [least, most] :
       std::vector<std::pair<float, float>>{{0.0f, 0.0f}, {5.0f, 5.0f}, {kNan, kNan}, {0.0f, kNan}, {9.0f, -1.0f}}) {
    CAPTURE(least, most);
    sensor_msgs::LaserScan scan = RosScan();
    scan.range_min = least;
    scan.range_max = most;
    CHECK(Read(scan)->ranges_m == scan.ranges);
  }
  sensor_msgs::LaserScan endless = RosScan();
  endless.range_max = kInfinity;
  CHECK(Read(endless)->ranges_m == std::vector<float>{0.5f, 0.0f, 11.0f, 10.0f});
}

TEST_CASE(
    "where a scan of ROS says how long a beam takes, its utime is that of the last one, as its beams' times are") {
  sensor_msgs::LaserScan message = RosScan();
  message.time_increment = 0.0625f;  // 0.1875 s from the first beam to the last
  const auto scan = Read(message);
  REQUIRE(scan);
  CHECK(scan->utime == 100'437'501);
  CHECK(scan->times_s == std::vector<float>{-0.1875f, -0.125f, -0.0625f, 0.0f});
  for (const float increment : {0.0f, 0.34f, kNan, kInfinity}) {  // more than a second is no sweep
    CAPTURE(increment);
    message.time_increment = increment;
    REQUIRE(Read(message));
    CHECK(Read(message)->times_s.empty());
    CHECK(Read(message)->utime == 100'250'001);
  }
}

TEST_CASE("a scan of ROS needs a time, angles within a turn, and from 2 to 65536 beams") {
  CHECK(IsRead([](auto&) {}));
  CHECK_FALSE(IsRead([](auto& scan) { scan.header.stamp.sec = -1; }));
  CHECK_FALSE(IsRead([](auto& scan) { scan.header.stamp.nsec = -1; }));
  CHECK_FALSE(IsRead([](auto& scan) { scan.header.stamp.nsec = 1'000'000'000; }));
  CHECK_FALSE(IsRead([](auto& scan) { scan.angle_min = -90.0f; }));
  CHECK_FALSE(IsRead([](auto& scan) { scan.angle_min = kNan; }));
  CHECK_FALSE(IsRead([](auto& scan) { scan.angle_increment = 0.0f; }));
  CHECK_FALSE(IsRead([](auto& scan) { scan.angle_increment = 3.0f; }));
  CHECK_FALSE(IsRead([](auto& scan) { scan.angle_increment = kNan; }));
  CHECK_FALSE(IsRead([](auto& scan) { scan.intensities = {1.0f}, scan.intensities_length = 1; }));
  CHECK(IsRead([](auto& scan) { scan.intensities.resize(4), scan.intensities_length = 4; }));
  for (const int num_beams : {0, 1, 2, 65536, 65537}) {
    CAPTURE(num_beams);
    const bool read = IsRead([&](auto& scan) {
      scan.angle_increment = 0.00005f;
      scan.ranges.assign(static_cast<std::size_t>(num_beams), 1.0f);
      scan.ranges_length = num_beams;
    });
    CHECK(read == (num_beams == 2 || num_beams == 65536));
  }
}

TEST_CASE("a scan of ROS that is cut, lengthened or counted wrongly is refused") {
  using Bytes = std::vector<std::uint8_t>;
  const Bytes bytes = Encode(RosScan());
  for (std::size_t size = 0; size < bytes.size(); ++size) {  // a copy, so that reading beyond it is an error
    CHECK_FALSE(DecodeLaser(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)), {}));
  }
  Bytes longer = bytes;
  longer.push_back(0);
  CHECK_FALSE(DecodeLaser(longer, {}));
  for (const std::size_t count_at : {std::size_t{8}, std::size_t{12}}) {
    for (const int byte : {0x01, 0x40, 0x7f, 0x80, 0xff}) {
      Bytes hostile = bytes;
      hostile[count_at] = static_cast<std::uint8_t>(byte);
      CHECK_FALSE(DecodeLaser(hostile, {}));
    }
  }
}

}  // namespace crsm
