#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "services/sources/bags/bag_reader.hpp"
#include "services/sources/bags/scan_messages.hpp"
#include "services/sources/bags/transform_tree.hpp"
#include "services/sources/scans_with_odometry.hpp"

namespace crsm {

/// The topic of a laser, and the frame of the scans to take, where several lasers are on it.
struct BagLaser {
  BagTopic topic;
  std::string frame;
};

/// The odometry of a bag: from a topic of nav_msgs/Odometry, if it is the only one or `odom` in the laser's namespace;
/// from TF where there is no such topic; or from what is named.
///
/// TF is read ahead for the place of the laser on the robot. It then says where the laser is: a
/// laser off the centre moves when the robot turns on the spot. Without TF it says where the robot is.
class BagOdometry {
 public:
  /// named: topic, or frame of TF; empty for the usual ones. Throws std::runtime_error that lists what there is, if the
  /// bag has not what is named.
  BagOdometry(const std::string& path, const std::set<BagTopic>& topics, const BagLaser& laser,
              const std::string& named);

  /// Whether the laser hangs upside down by the TF of the bag's first part.
  bool laser_is_upside_down() const { return laser_is_upside_down_; }

  /// Whether messages of this topic are to be taken.
  bool Wants(const BagTopic& topic) const;

  /// Gives `scans` the odometry of a message. Returns how much in it was malformed.
  std::int64_t Take(const std::string& topic, std::string_view data, ScansWithOdometry& scans);

  /// "base_link in /odom", "base_footprint in the frame odom of TF"; empty where there is none.
  std::string Describe() const;

  /// What a user is to know, as of LaserSource::OdometryNotes. scans: all of the bag.
  std::vector<std::string> Notes(const ScansWithOdometry& scans) const;

 private:
  struct Survey;

  void Choose(const std::string& path, const std::set<BagTopic>& topics);
  Survey LookAhead(const std::string& path) const;
  void FindRobot(const Survey& survey, const std::string& path, const std::set<BagTopic>& topics);
  void ChooseRobot(const Survey& survey);
  void FindMounting(const Survey& survey);
  std::int64_t TakeOdometry(std::string_view data, ScansWithOdometry& scans);
  std::optional<std::vector<Transform>> Decode(const std::string& topic, std::string_view data) const;
  std::int64_t TakeTransforms(const std::vector<Transform>& transforms, ScansWithOdometry& scans);
  void CheckJoint(const Transform& transform);
  void Add(const Odometry& odometry, ScansWithOdometry& scans) const;
  std::string DescribeMounting() const;

  BagLaser laser_;
  std::string named_;
  std::optional<BagTopic> topic_;               ///< with the odometry; nothing where it is in TF
  std::map<std::string, BagTopic> transforms_;  ///< topics of TF, by name
  std::string odometry_frame_;                  ///< of TF: where there is no topic
  std::string robot_frame_;                     ///< whose pose the odometry is
  FoundMounting found_;                         ///< where the laser stands on it
  bool laser_is_upside_down_ = false;
  std::string moved_joint_;  ///< the frame that has moved on the robot; empty for none
  std::string refusal_;      ///< why no odometry is used; empty where some is, or nothing could be meant
};

}  // namespace crsm
