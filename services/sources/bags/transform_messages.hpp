#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/math/pose2.hpp"
#include "services/sources/bags/bag_reader.hpp"

namespace crsm {

/// Where one frame stands in another, as TF says it.
struct Transform {
  std::int64_t utime = 0;  ///< means nothing on /tf_static
  std::string parent;
  std::string child;
  std::optional<Eigen::Isometry3d> T_parent_child;  ///< [m]; nothing where the numbers are no pose, or the time is none
};

/// Whether messages of this topic are read as TF: tf2_msgs/TFMessage of ROS 1 and 2, and the older tf/tfMessage.
bool IsTransformTopic(const BagTopic& topic);

/// Reads a message of such a topic; nothing if it is malformed.
std::optional<std::vector<Transform>> DecodeTransforms(const BagTopic& topic, std::string_view data);

/// What is left of a pose in the plane: its place, and the heading of its x axis, as RoundOdometry leaves it.
std::optional<Pose2> InPlane(const Eigen::Isometry3d& T_a_b);

}  // namespace crsm
