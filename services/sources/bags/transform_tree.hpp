#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/math/pose2.hpp"
#include "services/sources/bags/transform_messages.hpp"

namespace crsm {

/// Where the laser stands on the robot.
struct Mounting {
  Pose2 T_robot_laser;            ///< its place, and the heading of its x axis
  bool is_upside_down = false;    ///< its z axis points down: its scans are mirror images
  std::vector<Transform> joints;  ///< of which it is made
};

/// A mounting, or why there is none: "TF does not lead from laser to base_link".
struct FoundMounting {
  std::optional<Mounting> mounting;
  std::string refusal;
};

/// The frames of a robot as TF tells them, each with the frame it stands in. Of each transform the last one counts.
/// Bounded, whatever is added.
class TransformTree {
 public:
  /// odometry_frame: the name of the frame in which the robot moves by its wheels; empty for any whose name is usual.
  explicit TransformTree(std::string odometry_frame = "") : odometry_frame_(std::move(odometry_frame)) {}

  /// Whether the tree has another shape now. A frame keeps the odometry frame as its parent, and takes a map only where
  /// it has no other: another program's map and the wheels' odometry may both claim the robot.
  bool Add(const Transform& transform);

  /// The frames in which robots move by their wheels: the chosen one, or each named `odom` or `odom_combined`, perhaps
  /// behind a prefix.
  bool IsOdometryFrame(const std::string& frame) const;

  /// The frame and those in which it stands, one after the other: up to an odometry frame or a map, as far as TF tells,
  /// and never twice through a loop.
  std::vector<std::string> FindPath(const std::string& frame) const;

  /// Transforms out of odometry frames, one for each robot.
  std::vector<Transform> FindRobots() const;

  /// Where a laser stands on a robot. No way leads through an odometry frame or a map, to which the robot moves.
  FoundMounting FindMounting(const std::string& robot, const std::string& laser) const;

  /// Whether a laser hangs upside down on a robot, as far as TF tells. robot: empty where it is not known: the frame
  /// counts in which all others stand that carry the laser.
  bool IsUpsideDown(const std::string& robot, const std::string& laser) const;

  /// All frames that others stand in.
  std::vector<std::string> ListParents() const;

 private:
  /// FindPath without the odometry frame or the map at its end.
  std::vector<std::string> FindPathOnRobot(const std::string& frame) const;

  std::string odometry_frame_;
  std::map<std::string, Transform> by_child_;
};

}  // namespace crsm
