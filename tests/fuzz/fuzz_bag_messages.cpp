// What the messages of bags hold: of lasers and of odometry, as ROS 1, ROS 2 and Foxglove encode them.

#include <array>
#include <string_view>

#include "common/math/pose2.hpp"
#include "input.hpp"
#include "services/sources/bags/scan_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  static const std::array<BagTopic, 5> kTopics{{{"/scan", "sensor_msgs/LaserScan", "ros1"},
                                                {"/scan", "sensor_msgs/msg/LaserScan", "cdr"},
                                                {"/scan", "foxglove.LaserScan", "json"},
                                                {"/odom", "nav_msgs/Odometry", "ros1"},
                                                {"/odom", "nav_msgs/msg/Odometry", "cdr"}}};
  if (size == 0) return 0;
  const BagTopic& topic = kTopics[data[0] % kTopics.size()];
  const std::string_view message(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (IsLaserTopic(topic)) {
    const DecodedScan decoded = DecodeScan(topic, message);
    if (decoded.scan.has_value() != decoded.refusal.empty()) std::abort();
  } else if (const auto odometry = DecodeOdometry(topic, message)) {
    if (odometry->utime < 0) std::abort();
  }
  return 0;
}
