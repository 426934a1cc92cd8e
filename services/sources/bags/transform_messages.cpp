#include "services/sources/bags/transform_messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "services/sources/bags/ros_message.hpp"

namespace crsm {
namespace {

/// geometry_msgs/Transform; nothing if its numbers are no pose.
std::optional<Eigen::Isometry3d> ReadPose(ByteReader& reader) {
  constexpr double kLargest_m = 1e6;  // as of poses on the wire
  Eigen::Vector3d position_m;
  for (double& coordinate : position_m) coordinate = reader.Read<double>();
  Eigen::Quaterniond rotation;
  for (double& part : rotation.coeffs()) part = reader.Read<double>();   // x, y, z, w
  const bool is_place = (position_m.array().abs() <= kLargest_m).all();  // false for NaN
  const bool is_rotation = std::abs(rotation.squaredNorm() - 1.0) <= 0.01;
  if (!is_place || !is_rotation) return std::nullopt;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(position_m).rotate(rotation.normalized());
  return pose;
}

/// geometry_msgs/TransformStamped.
Transform ReadTransform(RosMessage& message) {
  RosHeader header = ReadHeader(message);
  Transform transform{ToUtime(header.stamp), std::move(header.frame), ReadFrame(message.reader),
                      ReadPose(message.reader)};
  const bool is_time = header.stamp.sec >= 0 && header.stamp.nanosec < kRosSecond_ns;
  if (!is_time) transform.T_parent_child.reset();
  return transform;
}

}  // namespace

bool IsTransformTopic(const BagTopic& topic) {
  static const std::array<BagTopic, 3> kKinds{
      {{"", "tf2_msgs/TFMessage", "ros1"}, {"", "tf/tfMessage", "ros1"}, {"", "tf2_msgs/msg/TFMessage", "cdr"}}};
  return std::any_of(kKinds.begin(), kKinds.end(),
                     [&](const BagTopic& kind) { return topic.type == kind.type && topic.encoding == kind.encoding; });
}

std::optional<std::vector<Transform>> DecodeTransforms(const BagTopic& topic, std::string_view data) {
  constexpr std::size_t kFewestBytes = 4 + 4 + 4 + 4 + 7 * sizeof(double);  // stamp, two empty names, pose
  auto message = OpenMessage(topic, data);
  if (!message) return std::nullopt;
  const auto count = message->reader.Read<std::uint32_t>();
  if (!message->reader.ok() || count > message->reader.left() / kFewestBytes) return std::nullopt;
  std::vector<Transform> transforms;
  for (std::uint32_t i = 0; i < count && message->reader.ok(); ++i) transforms.push_back(ReadTransform(*message));
  return message->IsWhole() ? std::optional(std::move(transforms)) : std::nullopt;
}

std::optional<Pose2> InPlane(const Eigen::Isometry3d& T_a_b) {
  const auto& position_m = T_a_b.translation();
  const auto& axes = T_a_b.linear();
  return RoundOdometry({position_m.x(), position_m.y(), std::atan2(axes(1, 0), axes(0, 0))});
}

}  // namespace crsm
