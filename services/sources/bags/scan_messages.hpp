#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/scan/laser_scan.hpp"
#include "common/scan/odometry_buffer.hpp"
#include "services/sources/bags/bag_reader.hpp"

namespace crsm {

/// The scan in a message, or why there is none: in a sentence for people.
struct DecodedScan {
  std::optional<LaserScan> scan;
  std::string refusal;
};

/// Whether messages of this topic are read as a laser's: sensor_msgs/LaserScan of ROS 1 and 2, and
/// foxglove.LaserScan in JSON.
bool IsLaserTopic(const BagTopic& topic);

/// Whether they are read as odometry: nav_msgs/Odometry of ROS 1 and 2.
bool IsOdometryTopic(const BagTopic& topic);

/// "sensor_msgs/LaserScan, ..." of IsLaserTopic.
std::string LaserTopicTypes();

/// Reads a message of a laser's topic.
DecodedScan DecodeScan(const BagTopic& topic, std::string_view data);

/// Reads a message of a topic with odometry; nothing if it is malformed.
std::optional<Odometry> DecodeOdometry(const BagTopic& topic, std::string_view data);

}  // namespace crsm
