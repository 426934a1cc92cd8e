#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/scan/laser_scan.hpp"
#include "common/scan/odometry_buffer.hpp"
#include "services/sources/bags/bag_reader.hpp"

namespace crsm {

/// A sweep that a message of a laser holds.
struct BagSweep {
  /// As LASER has it; its utime is that of the last beam, where the message knows how long its sweep takes, and else
  /// that of its stamp.
  LaserScan scan;
  double sweep_s = 0.0;  ///< from the first beam to the last; 0 if it is unknown
};

/// The sweep in a message, or why there is none: in a sentence for people.
struct DecodedSweep {
  std::optional<BagSweep> sweep;
  std::string refusal;
};

/// Whether messages of this topic are read as a laser's: sensor_msgs/LaserScan of ROS 1 and 2, and
/// foxglove.LaserScan in JSON.
bool IsLaserTopic(const BagTopic& topic);

/// Whether they are read as odometry: nav_msgs/Odometry of ROS 1 and 2.
bool IsOdometryTopic(const BagTopic& topic);

/// "sensor_msgs/LaserScan, ..." of IsLaserTopic.
std::string LaserTopicTypes();

/// Reads a message of a laser's topic. Ranges outside of what the message calls its range, up to infinity and NaN, are
/// 0 = no return; so is one that is range_max itself, which simulators and older drivers set for it.
DecodedSweep DecodeSweep(const BagTopic& topic, std::string_view data);

/// Reads a message of a topic with odometry; nothing if it is malformed.
std::optional<Odometry> DecodeOdometry(const BagTopic& topic, std::string_view data);

}  // namespace crsm
