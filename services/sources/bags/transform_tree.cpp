#include "services/sources/bags/transform_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

/// "odom" of "robot1/odom".
std::string_view WithoutPrefix(std::string_view frame) { return frame.substr(frame.rfind('/') + 1); }

/// A frame in which another SLAM corrects the robot's pose: it jumps, and is no odometry.
bool IsMap(const std::string& frame) {
  const std::string_view name = WithoutPrefix(frame);
  return name == "map" || name == "world";
}

/// A mounting in the plane of the robot.
FoundMounting MakeMounting(const Eigen::Isometry3d& T_robot_laser, std::vector<Transform> joints) {
  constexpr double kLeastUpright = 0.7;  // cosine of 45 degrees: a laser that leans further does not scan the plane
  const double upright = T_robot_laser.linear()(2, 2);
  if (std::abs(upright) < kLeastUpright) {
    const double tilt_deg = std::acos(std::clamp(upright, -1.0, 1.0)) * 180.0 / kPi;
    return {{}, fmt::format("TF tilts it by {:.0f} deg", tilt_deg)};
  }
  const auto in_plane = InPlane(T_robot_laser);
  if (!in_plane) return {{}, "TF puts it too far away"};
  return {Mounting{*in_plane, upright < 0.0, std::move(joints)}, ""};
}

}  // namespace

bool TransformTree::Add(const Transform& transform) {
  constexpr std::size_t kMostFrames = 4096;  // a robot has some dozens
  constexpr std::size_t kLongest = 256;
  if (!transform.T_parent_child || transform.parent.size() > kLongest || transform.child.size() > kLongest)
    return false;
  const auto known = by_child_.find(transform.child);
  if (known == by_child_.end()) {
    if (by_child_.size() >= kMostFrames) return false;
    by_child_.emplace(transform.child, transform);
    return true;
  }
  const bool is_other_parent = known->second.parent != transform.parent;
  if (is_other_parent && (IsMap(transform.parent) || IsOdometryFrame(known->second.parent))) return false;
  known->second = transform;
  return is_other_parent;
}

bool TransformTree::IsOdometryFrame(const std::string& frame) const {
  if (!odometry_frame_.empty()) return frame == odometry_frame_;
  const std::string_view name = WithoutPrefix(frame);
  return name == "odom" || name == "odom_combined";
}

std::vector<std::string> TransformTree::FindPath(const std::string& frame) const {
  constexpr std::size_t kMostFrames = 64;  // of a path; an arm with a laser at its end has twenty
  std::vector<std::string> path{frame};
  while (path.size() < kMostFrames) {
    const auto next = by_child_.find(path.back());
    if (next == by_child_.end()) break;
    const std::string& parent = next->second.parent;
    if (std::find(path.begin(), path.end(), parent) != path.end()) break;  // a loop
    path.push_back(parent);
    if (IsOdometryFrame(parent) || IsMap(parent)) break;
  }
  return path;
}

std::vector<std::string> TransformTree::FindPathOnRobot(const std::string& frame) const {
  std::vector<std::string> path = FindPath(frame);
  if (path.size() > 1 && (IsOdometryFrame(path.back()) || IsMap(path.back()))) path.pop_back();
  return path;
}

std::vector<Transform> TransformTree::FindRobots() const {
  std::vector<Transform> robots;
  for (const auto& [child, transform] : by_child_) {
    if (IsOdometryFrame(transform.parent)) robots.push_back(transform);
  }
  return robots;
}

FoundMounting TransformTree::FindMounting(const std::string& robot, const std::string& laser) const {
  const std::vector<std::string> from_laser = FindPathOnRobot(laser);
  const std::vector<std::string> from_robot = FindPathOnRobot(robot);
  const auto meeting = std::find_first_of(from_laser.begin(), from_laser.end(), from_robot.begin(), from_robot.end());
  if (meeting == from_laser.end()) return {{}, fmt::format("TF does not lead from {} to {}", laser, robot)};
  std::vector<Transform> joints;
  const auto Climb = [&](const std::vector<std::string>& path) {
    Eigen::Isometry3d T_meeting_start = Eigen::Isometry3d::Identity();
    for (auto frame = path.begin(); *frame != *meeting; ++frame) {
      joints.push_back(by_child_.at(*frame));
      T_meeting_start = *joints.back().T_parent_child * T_meeting_start;
    }
    return T_meeting_start;
  };
  const Eigen::Isometry3d T_meeting_laser = Climb(from_laser);
  const Eigen::Isometry3d T_meeting_robot = Climb(from_robot);
  return MakeMounting(T_meeting_robot.inverse() * T_meeting_laser, std::move(joints));
}

bool TransformTree::IsUpsideDown(const std::string& robot, const std::string& laser) const {
  FoundMounting found = FindMounting(robot, laser);
  if (!found.mounting) found = FindMounting(FindPathOnRobot(laser).back(), laser);
  return found.mounting && found.mounting->is_upside_down;
}

std::vector<std::string> TransformTree::ListParents() const {
  std::set<std::string> parents;
  for (const auto& [child, transform] : by_child_) parents.insert(transform.parent);
  return {parents.begin(), parents.end()};
}

}  // namespace crsm
