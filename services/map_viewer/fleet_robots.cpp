#include "services/map_viewer/fleet_robots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "services/wire/channels.hpp"

namespace crsm {

bool FleetRobots::Hear(const fleet_pose_t& pose, Clock::time_point now) {
  if (pose.robot.size() > kLongestChannel) return false;
  if (robots_.size() == kMost && !robots_.contains(pose.robot)) return false;
  robots_[pose.robot] = {pose, now};
  return true;
}

void FleetRobots::Show() { shown_before_ = std::exchange(shown_, newest_); }

const FleetRobots::Robot* FleetRobots::FindOwner(std::int64_t trajectory) const {
  const auto found = std::ranges::find_if(robots_, [&](const auto& robot) {
    return std::ranges::binary_search(robot.second.pose.trajectories, trajectory);
  });
  return found == robots_.end() ? nullptr : &found->second;
}

const ScanMatch* FleetRobots::FindNewest(const Robot& robot, const Newest& newest) {
  const auto& trajectories = robot.pose.trajectories;
  for (auto trajectory = trajectories.rbegin(); trajectory != trajectories.rend(); ++trajectory) {
    if (const auto found = newest.find(*trajectory); found != newest.end()) return &found->second;
  }
  return nullptr;
}

std::string FleetRobots::NameOf(std::int64_t trajectory) const {
  const Robot* owner = FindOwner(trajectory);
  return owner ? owner->pose.robot : fmt::format("trajectory {}", trajectory);
}

/// A join is told of the robot that floated before: the other one was on the map that is shown.
std::string FleetRobots::DescribeJoin(const JoinEvent& event) {
  const auto Floated = [&](const Robot* robot) {
    const ScanMatch* before = robot ? FindNewest(*robot, shown_before_) : nullptr;
    return before && before->floating;
  };
  const Robot* robot = FindOwner(event.trajectory);
  if (const Robot* other = FindOwner(event.other); other && !Floated(robot) && Floated(other)) robot = other;
  const ScanMatch* newest = robot ? FindNewest(*robot, shown_) : nullptr;
  if (!newest) return crsm::Describe(event);
  const Pose2& there = newest->T_map_laser;
  joined_at_.push_back({there.x_m, there.y_m});
  return fmt::format("{} joined at {:.1f}, {:.1f}", robot->pose.robot, there.x_m, there.y_m);
}

std::vector<std::string> FleetRobots::DescribeNews(const std::vector<JoinEvent>& events) {
  std::vector<std::array<double, 2>> before = std::exchange(joined_at_, {});
  std::vector<std::string> lines;
  for (const JoinEvent& event : events) {
    lines.push_back(event.kind == JoinEvent::Kind::kJoined ? DescribeJoin(event) : crsm::Describe(event, [&](auto at) {
      return NameOf(at);
    }));
  }
  if (joined_at_.empty()) {
    joined_at_ = std::move(before);
  } else {
    ++num_joins_;
  }
  return lines;
}

nlohmann::json FleetRobots::Describe(Clock::time_point now) const {
  constexpr auto kHeardWithin = std::chrono::seconds(10);  // as fleet_mapper has it
  const auto ToJson = [](const auto& pose) { return nlohmann::json{pose.x_m, pose.y_m, pose.yaw_rad}; };
  nlohmann::json list = nlohmann::json::array();
  for (const auto& [name, robot] : robots_) {
    const fleet_pose_t& pose = robot.pose;
    list.push_back({{"name", name},
                    {"epoch", std::to_string(pose.epoch)},
                    {"floating", pose.floating == 1},
                    {"heard", pose.heard == 1 && now - robot.heard < kHeardWithin},
                    {"keyframes", pose.num_keyframes},
                    {"covariance", pose.covariance},
                    {"T_common_map", ToJson(pose.T_common_map)},
                    {"trajectories", pose.trajectories}});
    if (const ScanMatch* newest = FindNewest(robot, shown_)) list.back()["newest"] = ToJson(newest->T_map_laser);
  }
  return {{"robots", list}, {"joins", {{"number", num_joins_}, {"places", joined_at_}}}};
}

}  // namespace crsm
