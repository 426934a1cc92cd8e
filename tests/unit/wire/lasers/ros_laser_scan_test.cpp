#include <limits>
#include <sensor_msgs/LaserScan.hpp>

#include "catch.hpp"
#include "services/wire/laser_types.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::optional<LaserScan> Read(const sensor_msgs::LaserScan& scan) {
  auto reading = DecodeLaser(Encode(scan), {});
  return reading ? std::optional(reading->scan) : std::nullopt;
}

template <class Change>
bool IsRead(Change change) {
  sensor_msgs::LaserScan scan = RosScanMessage();
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
  sensor_msgs::LaserScan message = RosScanMessage();
  message.ranges.assign(5520, 1.0f);
  message.ranges_length = 5520;
  message.angle_increment = 0.001f;
  const auto reading = DecodeLaser(Encode(message), {});
  REQUIRE(reading);
  CHECK(reading->frame == "laser");
  CHECK(reading->scan.ranges_m.size() == 2760);
  CHECK(reading->scan.angle_step_rad == 0.002f);
  CHECK(reading->thinned == "scans have 5520 beams, of which one in 2 is used, because 4096 are the most");
  CHECK(DecodeLaser(Encode(RosScanMessage()), {})->thinned.empty());
  message.angle_min = 2.75f;
  message.angle_max = 2.75f - 5.519f;
  const std::string contradiction = DecodeLaser(Encode(message), {})->contradiction;
  CHECK(
      contradiction.starts_with("headers contradict themselves: angle_increment is 0.0010 rad, but angle_max -2.7690"));
  CHECK(DecodeLaser(Encode(RosScanMessage()), {})->contradiction.empty());
}

// What a scan of ROS means is tested with those in bags, too: scan_messages_test.cpp.
TEST_CASE("a scan of ROS has its stamp as utime, and no return where a range is at its upper limit or beyond") {
  const auto scan = Read(RosScanMessage());
  REQUIRE(scan);
  CHECK(*scan == LaserScan{100'250'001, -0.5f, 0.25f, {0.5f, 0.0f, 0.0f, 0.0f}});
  sensor_msgs::LaserScan sweep = RosScanMessage();
  sweep.time_increment = 0.0625f;  // 0.1875 s from the first beam to the last
  CHECK(Read(sweep)->utime == 100'437'501);
  CHECK(Read(sweep)->times_s == std::vector<float>{-0.1875f, -0.125f, -0.0625f, 0.0f});
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

}  // namespace crsm
