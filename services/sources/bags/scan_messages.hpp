#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/odometry_buffer.hpp"
#include "services/sources/bags/bag_reader.hpp"

namespace crsm {

/// The scan in a message, or why there is none: in a sentence for people.
struct DecodedScan {
  std::optional<LaserScan> scan;
  std::string refusal;
  std::string frame = {};          ///< of the laser; empty where the message names none
  std::string thinned = {};        ///< as of ThinBeams
  std::string contradiction = {};  ///< as of DescribeContradiction
};

/// Where the robot stood by its odometry, and which frame of TF this robot is.
struct RobotOdometry {
  Odometry sample;
  std::string robot_frame;  ///< child_frame_id; empty where the message names none
};

/// Whether messages of this topic are read as a laser's: sensor_msgs/LaserScan and MultiEchoLaserScan of ROS 1 and 2,
/// and foxglove.LaserScan in JSON.
bool IsLaserTopic(const BagTopic& topic);

/// Whether they are read as odometry: nav_msgs/Odometry of ROS 1 and 2.
bool IsOdometryTopic(const BagTopic& topic);

/// Whether they are read as odometry if somebody names the topic: also geometry_msgs/PoseStamped.
bool IsPoseTopic(const BagTopic& topic);

/// "sensor_msgs/LaserScan, ..." of IsLaserTopic.
std::string LaserTopicTypes();

/// Reads a message of a laser's topic.
DecodedScan DecodeScan(const BagTopic& topic, std::string_view data, const ScanParameters& parameters = {});

/// Reads a message of a topic with odometry or poses; nothing if it is malformed.
std::optional<RobotOdometry> DecodeOdometry(const BagTopic& topic, std::string_view data);

}  // namespace crsm
