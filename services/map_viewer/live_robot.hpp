#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/diagnosis/changes.hpp"
#include "common/map/byte_map.hpp"
#include "common/metrics/path_sketch.hpp"
#include "services/base/held_by_utime.hpp"
#include "services/bus/service.hpp"
#include "services/map_viewer/fleet_robots.hpp"
#include "services/map_viewer/join_news.hpp"
#include "services/map_viewer/scene.hpp"
#include "services/replica/map_follower.hpp"

namespace crsm {

/// Hears a robot's stack on the bus, or the mapper of a fleet, and makes a scene of it.
///
/// The map and the path are asked for as an exporter does, all that was seen where it belongs by all that is known, and
/// so seldom that the owner spends no more than a twentieth of its time on the answers. What is drawn over them, the
/// last scan and its match, comes by itself.
class LiveRobot {
 public:
  /// command_line: tells the bus and the channel prefix.
  explicit LiveRobot(const CommandLine& command_line);

  Service& service() { return service_; }
  const Scene& scene() const { return scene_; }

  /// To be called after each batch of messages. is_watched: whether somebody looks.
  void Step(bool is_watched);

  /// Whether the next page of the map is waited for, and is not to wait itself.
  bool is_fetching() const { return !map_follower_.replica().synced() && map_follower_.replica().epoch() != 0; }

 private:
  void TakeRole();
  struct LocalPose {
    std::int64_t utime = 0;
    Pose2 T_local_laser;
  };
  struct StageTimes {
    double median_ms = 0.0;
    double p99_ms = 0.0;
  };
  struct HeardStatus {
    service_status_t status;
    Clock::time_point heard;
  };

  void Begin(double cell_size_m);
  bool Apply(std::span<const TileChange> changes);
  void Add(const ScanMatch& match);
  void Hear(const scan_match_t& match);
  void Hear(const bot_core::pose_t& local_pose);
  void Hear(const fleet_pose_t& pose);
  void Show(ScanMatch match);
  void ForgetRun();
  void Keep(const service_status_t& status);

  void SendMarks();
  void AskNowAndThen(bool is_watched);
  void ShowMap();
  void ShowInfo();

  Service service_;
  bool has_role_ = false;  ///< to tell the robot where it is
  Scene scene_;
  MapFollower map_follower_;

  // The map as it comes.
  std::optional<ByteMap> map_;
  std::set<TileIndex> touched_;  ///< since it was shown last
  bool is_anew_ = false;         ///< begun since it was shown whole
  PathSketch path_;
  bool path_is_anew_ = true;
  JoinNews join_news_;
  FleetRobots fleet_;  ///< empty where this is one robot
  std::optional<Clock::time_point> asked_;
  Clock::time_point next_ask_{};
  Clock::time_point next_glimpse_{};

  // The robot on it.
  HeldByUtime<CriticalRays, 64> scans_;
  std::optional<ScanMatch> last_match_;  ///< that was heard
  std::optional<ScanMatch> last_known_;  ///< on the map that is shown
  HeldByUtime<LocalPose, 4096> local_poses_;
  std::optional<Pose2> T_best_local_;  ///< from the frame that never jumps onto the map that is shown

  /// Of the page, until the owner of the map has kept it.
  struct SentMark {
    Mark mark;
    Clock::time_point next_try;
    int tries = 0;
  };
  static constexpr std::size_t kMostSentMarks = 256;
  std::deque<SentMark> sent_marks_;

  std::optional<Clock::time_point> scan_heard_;
  std::optional<Clock::time_point> match_heard_;
  std::vector<MapChange> changes_;  ///< since the finished map was made, where there is one
  std::map<std::string, HeardStatus> statuses_;
  std::deque<StageTimes> stage_times_;  ///< once a second
  Clock::time_point next_info_{};
};

}  // namespace crsm
