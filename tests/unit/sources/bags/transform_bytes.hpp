#pragma once

#include <array>
#include <string>
#include <vector>

#include "bag_bytes.hpp"

namespace crsm {

/// geometry_msgs/TransformStamped, and what its fields are when a test does not say.
struct TransformFields {
  std::string parent = "odom";
  std::string child = "base_link";
  double x_m = 0.0;
  double y_m = 0.0;
  std::array<double, 4> rotation = {0.0, 0.0, 0.0, 1.0};  ///< x, y, z, w
  std::uint32_t sec = 100;
  std::uint32_t nanosec = 0;

  std::string Pose() const {
    std::string bytes = Little(x_m) + Little(y_m) + Little(0.25);
    for (const double part : rotation) bytes += Little(part);
    return bytes;
  }
};

/// tf2_msgs/TFMessage and tf/tfMessage of ROS 1.
inline std::string Ros1Transforms(const std::vector<TransformFields>& transforms) {
  std::string bytes = Little(static_cast<std::uint32_t>(transforms.size()));
  for (const TransformFields& fields : transforms) {
    bytes += Little(7u) + Little(fields.sec) + Little(fields.nanosec) + Text(fields.parent) + Text(fields.child) +
             fields.Pose();
  }
  return bytes;
}

/// tf2_msgs/msg/TFMessage in CDR: numbers at multiples of their size, counted from behind the first four bytes.
inline std::string CdrTransforms(const std::vector<TransformFields>& transforms) {
  std::string bytes = Little(static_cast<std::uint32_t>(transforms.size()));
  const auto align = [&bytes](std::size_t size) { bytes.append((size - bytes.size() % size) % size, '\0'); };
  for (const TransformFields& fields : transforms) {
    align(4);
    bytes += Little(fields.sec) + Little(fields.nanosec) + Text(fields.parent + '\0');
    align(4);
    bytes += Text(fields.child + '\0');
    align(8);
    bytes += fields.Pose();
  }
  return std::string("\0\1\0\0", 4) + bytes;
}

/// nav_msgs/Odometry of ROS 1.
inline std::string Ros1Odometry(const TransformFields& fields) {
  return Little(7u) + Little(fields.sec) + Little(fields.nanosec) + Text(fields.parent) + Text(fields.child) +
         fields.Pose() + std::string((36 + 6 + 36) * 8, '\0');
}

/// geometry_msgs/PoseStamped of ROS 1.
inline std::string Ros1Pose(const TransformFields& fields) {
  return Little(7u) + Little(fields.sec) + Little(fields.nanosec) + Text(fields.parent) + fields.Pose();
}

}  // namespace crsm
