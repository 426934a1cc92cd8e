#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/scan/scan_match.hpp"
#include "services/map_viewer/join_news.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// The robots of a fleet, as FLEET_POSE tells of them, and where their newest keyframes lie on the common map.
///
/// It touches neither network nor clock.
class FleetRobots {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMost = 64;  ///< as many as fleet_mapper takes: the names come from the network

  /// False where it is of one robot too many, or of a prefix that no channel can have, and nothing is done.
  bool Hear(const fleet_pose_t& pose, Clock::time_point now);
  bool empty() const { return robots_.empty(); }

  /// The common map is told anew.
  void Begin() { newest_.clear(); }
  /// A keyframe of the common map, in their order.
  void Add(const ScanMatch& match) { newest_[match.trajectory] = match; }
  /// The common map is whole: what is told of keyframes from now on is as of it.
  void Show();

  /// What has happened, a line each, by the names of robots as far as they are known. To be called after Show.
  std::vector<std::string> DescribeNews(const std::vector<JoinEvent>& events);

  /// {"robots": [{"name", "epoch", "floating", "heard", "keyframes", "covariance", "T_common_map", "newest",
  /// "trajectories"}, ...], "joins": {"number", "places": [[x, y], ...]}}. The robots have the order of their names;
  /// "newest" [m, m, rad] is missing where no keyframe is known; "places" are those of the last joins, "number" counts
  /// how often there were some.
  nlohmann::json Describe(Clock::time_point now) const;

 private:
  struct Robot {
    fleet_pose_t pose;
    Clock::time_point heard;
  };
  /// robot2/ before robot10/, whichever was heard first: so that a robot has the same colour on each page.
  struct ShorterFirst {
    bool operator()(const std::string& a, const std::string& b) const {
      return a.size() != b.size() ? a.size() < b.size() : a < b;
    }
  };
  using Newest = std::map<int, ScanMatch>;  ///< keyframes by trajectory

  const Robot* FindOwner(std::int64_t trajectory) const;
  static const ScanMatch* FindNewest(const Robot& robot, const Newest& newest);
  std::string NameOf(std::int64_t trajectory) const;
  std::string DescribeJoin(const JoinEvent& event);

  std::map<std::string, Robot, ShorterFirst> robots_;
  Newest newest_;
  Newest shown_;         ///< as of the map that is shown, ...
  Newest shown_before_;  ///< ... and of the one before
  std::int64_t num_joins_ = 0;
  std::vector<std::array<double, 2>> joined_at_;
};

}  // namespace crsm
