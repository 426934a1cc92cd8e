// What the messages of bags hold: of lasers, of odometry and of TF, as ROS 1, ROS 2 and Foxglove encode them.

#include <array>
#include <string_view>

#include "common/math/pose2.hpp"
#include "input.hpp"
#include "services/sources/bags/scan_messages.hpp"
#include "services/sources/bags/transform_tree.hpp"
#include "services/wire/conversions.hpp"
#include "wire_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  static const std::array<BagTopic, 7> kTopics{{{"/scan", "sensor_msgs/LaserScan", "ros1"},
                                                {"/scan", "sensor_msgs/msg/LaserScan", "cdr"},
                                                {"/scan", "foxglove.LaserScan", "json"},
                                                {"/odom", "nav_msgs/Odometry", "ros1"},
                                                {"/odom", "nav_msgs/msg/Odometry", "cdr"},
                                                {"/tf", "tf2_msgs/TFMessage", "ros1"},
                                                {"/tf", "tf2_msgs/msg/TFMessage", "cdr"}}};
  if (size == 0) return 0;
  const BagTopic& topic = kTopics[data[0] % kTopics.size()];
  const std::string_view message(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (IsLaserTopic(topic)) {
    const DecodedScan decoded = DecodeScan(topic, message);
    if (decoded.scan.has_value() != decoded.refusal.empty()) std::abort();
    if (decoded.scan && decoded.scan->ranges_m.size() <= kMaxBeams &&  // more are thinned behind it
        !Decode<bot_core::planar_lidar_t>(Encode(ToMessage(*decoded.scan)))) {
      std::abort();
    }
  } else if (IsTransformTopic(topic)) {
    TransformTree tree;
    for (const Transform& transform : DecodeTransforms(topic, message).value_or(std::vector<Transform>())) {
      tree.Add(transform);
      tree.FindMounting(transform.parent, transform.child);
    }
  } else if (const auto odometry = DecodeOdometry(topic, message)) {
    if (odometry->sample.utime < 0) std::abort();
  }
  return 0;
}
