#include "services/sources/bags/bag_odometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "common/math/nearest_name.hpp"
#include "common/math/trigonometry.hpp"
#include "services/base/printable.hpp"
#include "services/sources/bags/decompress.hpp"

namespace crsm {
namespace {

using Topics = std::set<BagTopic>;

/// "robot1/" of "/robot1/scan".
std::string NamespaceOf(const std::string& topic) {
  const std::string name = topic.substr(topic.starts_with('/') ? 1 : 0);
  return name.substr(0, name.rfind('/') + 1);
}

/// "/robot1/odom" for "/robot1/scan".
std::string OdometryBeside(const std::string& laser) { return laser.substr(0, laser.rfind('/') + 1) + "odom"; }

std::optional<BagTopic> ChooseOdometry(const Topics& odometries, const std::string& laser) {
  if (odometries.size() == 1) return *odometries.begin();
  const auto beside = std::find_if(odometries.begin(), odometries.end(),
                                   [&](const BagTopic& topic) { return topic.name == OdometryBeside(laser); });
  return beside == odometries.end() ? std::nullopt : std::optional(*beside);
}

/// The TF of the laser's namespace, or of the nearest one around it: robots may have a TF each, with the same frames.
std::map<std::string, BagTopic> ChooseTransforms(const Topics& topics, const std::string& laser) {
  std::map<std::string, BagTopic> chosen;
  std::size_t nearest = 0;
  for (const BagTopic& topic : topics) {
    const std::string space = NamespaceOf(topic.name);
    if (!IsTransformTopic(topic) || !NamespaceOf(laser).starts_with(space) || space.size() < nearest) continue;
    if (space.size() > nearest) chosen.clear();
    nearest = space.size();
    chosen[topic.name] = topic;
  }
  return chosen;
}

/// Of those in one odometry frame the one that is named as robots are; nothing where several could be meant.
std::optional<Transform> ChooseRobotOf(const std::vector<Transform>& robots) {
  if (robots.size() == 1) return robots.front();
  const bool same_frame = std::all_of(robots.begin(), robots.end(),
                                      [&](const Transform& robot) { return robot.parent == robots.front().parent; });
  for (const char* name : {"base_link", "base_footprint"}) {
    const auto found =
        std::find_if(robots.begin(), robots.end(), [&](const Transform& robot) { return robot.child.ends_with(name); });
    if (same_frame && found != robots.end()) return *found;
  }
  return std::nullopt;
}

/// Whether two poses differ by more than rounding, and a robot that rocks a little.
bool Differ(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  constexpr double kMost_m = 0.02;
  constexpr double kMost_rad = 0.05;
  const Eigen::Isometry3d motion = a.inverse() * b;
  return motion.translation().norm() > kMost_m || Eigen::AngleAxisd(motion.linear()).angle() > kMost_rad;
}

/// How far TF leads from a laser.
std::string DescribePath(const std::vector<std::string>& path) {
  if (path.size() > 1) return fmt::format("TF leads from {} to {} and ends there", path.front(), path.back());
  return fmt::format("TF does not have the laser's frame {}", path.front());
}

/// "; did you mean /odom?", of topics and frames.
std::string SuggestOdometry(const std::string& wanted, const Topics& topics, std::vector<std::string> frames = {}) {
  for (const BagTopic& topic : topics) {
    if (IsPoseTopic(topic)) frames.push_back(topic.name);
  }
  return MakePrintable(SuggestName(wanted, frames));
}

std::string ListRobots(const std::vector<Transform>& robots) {
  std::vector<std::string> names;
  for (const Transform& robot : robots) names.push_back(fmt::format("{} in {}", robot.child, robot.parent));
  return ListPrintable(names);
}

}  // namespace

/// What the first part of a bag tells.
struct BagOdometry::Survey {
  explicit Survey(const std::string& odometry_frame) : tree(odometry_frame) {}

  std::string laser_frame;
  std::string robot_frame;  ///< of the odometry's topic
  TransformTree tree;

  /// Whether more of the bag could tell no more.
  bool IsComplete(bool has_topic) const {
    if (laser_frame.empty()) return false;
    if (has_topic) return !robot_frame.empty() && tree.FindMounting(robot_frame, laser_frame).mounting;
    return tree.IsOdometryFrame(tree.FindPath(laser_frame).back());
  }
};

BagOdometry::BagOdometry(const std::string& path, const Topics& topics, const BagLaser& laser, const std::string& named)
    : laser_(laser), named_(named), transforms_(ChooseTransforms(topics, laser.topic.name)) {
  Choose(path, topics);
  if (transforms_.empty()) {
    found_.refusal = "the bag has no TF";
    return;
  }
  const Survey survey = LookAhead(path);
  laser_is_upside_down_ = survey.tree.IsUpsideDown(survey.robot_frame, survey.laser_frame);
  if (!refusal_.empty()) return;
  FindRobot(survey, path, topics);
  if (refusal_.empty()) FindMounting(survey);
}

void BagOdometry::Choose(const std::string& path, const Topics& topics) {
  Topics odometries;
  std::copy_if(topics.begin(), topics.end(), std::inserter(odometries, odometries.end()),
               named_.empty() ? IsOdometryTopic : IsPoseTopic);
  if (!named_.empty()) {
    const auto named =
        std::find_if(odometries.begin(), odometries.end(), [&](const BagTopic& topic) { return topic.name == named_; });
    if (named != odometries.end()) {
      topic_ = *named;
    } else if (transforms_.empty()) {
      throw std::runtime_error(fmt::format("{} has no odometry {}; its topics of odometry: {}; it has no TF{}", path,
                                           named_, ListTopics(odometries), SuggestOdometry(named_, odometries)));
    }
    return;
  }
  topic_ = ChooseOdometry(odometries, laser_.topic.name);
  if (topic_) return;
  if (!odometries.empty()) {
    refusal_ = fmt::format("there is no topic {}, and several could be meant: --odometry-topic must name one of {}",
                           OdometryBeside(laser_.topic.name), ListTopics(odometries));
  }
}

/// Reads until all is known, or as much as tells whether it will ever be.
BagOdometry::Survey BagOdometry::LookAhead(const std::string& path) const {
  constexpr int kMostScans = 500;
  constexpr int kMostMessages = 200'000;
  Survey survey(named_.empty() || topic_ ? "" : named_);
  const auto bag = OpenBag(path, [&](const BagTopic& topic) {
    return topic == laser_.topic || topic == topic_ || transforms_.count(topic.name) > 0;
  });
  survey.laser_frame = laser_.frame;
  int num_scans = 0;
  for (int i = 0; i < kMostMessages && num_scans < kMostScans; ++i) {
    const auto message = bag->Next();
    if (!message) break;
    const PlainMessage plain(message->data);
    bool has_news = false;
    if (message->topic == laser_.topic.name) {
      ++num_scans;
      if (survey.laser_frame.empty()) survey.laser_frame = DecodeScan(laser_.topic, plain.data()).frame;
      has_news = num_scans == 1;
    } else if (topic_ && message->topic == topic_->name) {
      const auto odometry = DecodeOdometry(*topic_, plain.data());
      has_news = odometry && survey.robot_frame.empty();
      if (has_news) survey.robot_frame = odometry->robot_frame;
    } else {
      for (const Transform& transform : Decode(message->topic, plain.data()).value_or(std::vector<Transform>())) {
        has_news = survey.tree.Add(transform) || has_news;
      }
    }
    if (has_news && survey.IsComplete(topic_.has_value())) break;
  }
  return survey;
}

void BagOdometry::FindRobot(const Survey& survey, const std::string& path, const Topics& topics) {
  if (topic_) {
    robot_frame_ = survey.robot_frame;
    return;
  }
  ChooseRobot(survey);
  if (TransformTree().IsOdometryFrame(robot_frame_)) {
    refusal_ = fmt::format("the frame {} of TF moves {}, and that moves the robot: --odometry-topic {} is its odometry",
                           odometry_frame_, robot_frame_, robot_frame_);
  }
  if (refusal_.empty() || named_.empty() || !survey.tree.FindRobots().empty()) return;
  throw std::runtime_error(fmt::format(
      "{} has no odometry {}: neither a topic of nav_msgs/Odometry or geometry_msgs/PoseStamped, nor a frame of TF; "
      "frames in which others stand: {}{}",
      path, named_, ListPrintable(survey.tree.ListParents()),
      SuggestOdometry(named_, topics, survey.tree.ListParents())));
}

/// The robot on which the laser stands; where TF does not tell that, the only one.
void BagOdometry::ChooseRobot(const Survey& survey) {
  const std::vector<std::string> laser_path = survey.tree.FindPath(survey.laser_frame);
  if (laser_path.size() > 1 && survey.tree.IsOdometryFrame(laser_path.back())) {
    odometry_frame_ = laser_path.back();
    robot_frame_ = laser_path[laser_path.size() - 2];
    return;
  }
  const std::vector<Transform> robots = survey.tree.FindRobots();
  if (const auto robot = ChooseRobotOf(robots)) {
    odometry_frame_ = robot->parent;
    robot_frame_ = robot->child;
  } else if (robots.empty()) {
    refusal_ = fmt::format("{}, and has no frame odom: --odometry-topic may name another of its frames: {}",
                           DescribePath(laser_path), ListPrintable(survey.tree.ListParents()));
  } else {
    refusal_ = fmt::format("{}, and several robots could be meant: {}", DescribePath(laser_path), ListRobots(robots));
  }
}

void BagOdometry::FindMounting(const Survey& survey) {
  if (survey.laser_frame.empty()) {
    found_.refusal = "the scans name no frame";
  } else if (robot_frame_.empty()) {
    found_.refusal = "the odometry names no frame of the robot";
  } else {
    found_ = survey.tree.FindMounting(robot_frame_, survey.laser_frame);
  }
}

bool BagOdometry::Wants(const BagTopic& topic) const {
  if (topic == topic_) return true;
  const bool wants_transforms = refusal_.empty() && (!topic_ || found_.mounting);
  return wants_transforms && transforms_.count(topic.name) > 0;
}

std::int64_t BagOdometry::Take(const std::string& topic, std::string_view data, ScansWithOdometry& scans) {
  if (topic_ && topic == topic_->name) return TakeOdometry(data, scans);
  const auto transforms = Decode(topic, data);
  return transforms ? TakeTransforms(*transforms, scans) : 1;
}

std::int64_t BagOdometry::TakeOdometry(std::string_view data, ScansWithOdometry& scans) {
  const auto odometry = DecodeOdometry(*topic_, data);
  if (odometry) Add(odometry->sample, scans);
  return odometry ? 0 : 1;
}

std::optional<std::vector<Transform>> BagOdometry::Decode(const std::string& topic, std::string_view data) const {
  const auto found = transforms_.find(topic);
  return found == transforms_.end() ? std::nullopt : DecodeTransforms(found->second, data);
}

std::int64_t BagOdometry::TakeTransforms(const std::vector<Transform>& transforms, ScansWithOdometry& scans) {
  std::int64_t num_bad = 0;
  for (const Transform& transform : transforms) {
    const bool is_odometry = !topic_ && transform.parent == odometry_frame_ && transform.child == robot_frame_;
    if (!is_odometry) {
      CheckJoint(transform);
    } else if (transform.T_parent_child) {
      Add({transform.utime, InPlane(*transform.T_parent_child)}, scans);
    } else {
      ++num_bad;
    }
  }
  return num_bad;
}

void BagOdometry::CheckJoint(const Transform& transform) {
  if (!found_.mounting || !transform.T_parent_child || !moved_joint_.empty()) return;
  for (const Transform& joint : found_.mounting->joints) {
    const bool is_same = joint.child == transform.child && joint.parent == transform.parent;
    if (is_same && Differ(*joint.T_parent_child, *transform.T_parent_child)) moved_joint_ = joint.child;
  }
}

void BagOdometry::Add(const Odometry& odometry, ScansWithOdometry& scans) const {
  const bool is_placed = found_.mounting && odometry.T_odom_robot;
  scans.Add(is_placed ? Odometry{odometry.utime, RoundOdometry(*odometry.T_odom_robot * found_.mounting->T_robot_laser)}
                      : odometry);
}

std::vector<std::string> BagOdometry::Notes(const ScansWithOdometry& scans) const {
  if (!topic_ && transforms_.empty() && refusal_.empty()) return {};
  if (!refusal_.empty()) return {"has no odometry that can be used: " + refusal_};
  if (scans.num_with_odometry() == 0) {
    return {fmt::format("has odometry ({}), but gives it to no scan: {}", Describe(), scans.ExplainNoOdometry())};
  }
  std::vector<std::string> notes{fmt::format("gives odometry to {} of {} scans ({}): {}", scans.num_with_odometry(),
                                             scans.num_scans(), Describe(), DescribeMounting())};
  if (!moved_joint_.empty()) {
    notes.push_back(
        fmt::format("has a laser that moves on the robot: {} turns or shifts in TF, and counts as it stood "
                    "at first",
                    moved_joint_));
  }
  return notes;
}

std::string BagOdometry::Describe() const {
  if (!refusal_.empty() || (!topic_ && odometry_frame_.empty())) return "";
  const std::string where = topic_ ? topic_->name : fmt::format("the frame {} of TF", odometry_frame_);
  return robot_frame_.empty() ? where : fmt::format("{} in {}", robot_frame_, where);
}

std::string BagOdometry::DescribeMounting() const {
  if (!found_.mounting) return fmt::format("where the laser stands on the robot is not known, as {}", found_.refusal);
  const Pose2& pose = found_.mounting->T_robot_laser;
  return fmt::format("the laser stands at x {:.3f} m, y {:.3f} m, yaw {:.1f} deg on the robot", pose.x_m, pose.y_m,
                     pose.yaw_rad * 180.0 / kPi);
}

}  // namespace crsm
