#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace crsm {

/// Characters of a channel's name, with its prefix: of LCM.
inline constexpr std::size_t kLongestChannel = 63;

// The channels, and what travels on them.
inline constexpr const char* kLaserChannel = "LASER";                 // any type of LaserTypes()
inline constexpr const char* kOdometryChannel = "ODOMETRY";           // bot_core.pose_t, of a scan, before it
inline constexpr const char* kCriticalRaysChannel = "CRITICAL_RAYS";  // crsm.critical_rays_t
inline constexpr const char* kScanMatchChannel = "SCAN_MATCH";        // crsm.scan_match_t
inline constexpr const char* kPoseChannel = "POSE";                   // bot_core.pose_t
inline constexpr const char* kLocalPoseChannel = "POSE_LOCAL";        // bot_core.pose_t, in a frame that never jumps
inline constexpr const char* kTruePoseChannel = "TRUE_POSE";          // bot_core.pose_t, of simulated worlds
inline constexpr const char* kStartPoseChannel = "START_POSE";        // bot_core.pose_t, where a robot is told to stand
inline constexpr const char* kMapDeltaChannel = "MAP_DELTA";          // crsm.map_delta_t
inline constexpr const char* kMapRequestChannel = "MAP_REQUEST";      // crsm.map_request_t
inline constexpr const char* kMapPageChannel = "MAP_PAGE";            // crsm.map_page_t, of what is matched to
inline constexpr const char* kWholeMapChannel = "WHOLE_MAP";          // crsm.map_page_t, of all that was seen
inline constexpr const char* kScanRequestChannel = "SCAN_REQUEST";    // crsm.scan_request_t
inline constexpr const char* kScanAnswerChannel = "SCAN_ANSWER";      // crsm.scan_answer_t
inline constexpr const char* kKeyframeChannel = "KEYFRAME";           // crsm.keyframe_t
inline constexpr const char* kKeyframeRequestChannel = "KEYFRAME_REQUEST";  // crsm.keyframe_request_t
inline constexpr const char* kPoseGraphChannel = "POSE_GRAPH";              // crsm.pose_graph_t
inline constexpr const char* kChangesChannel = "CHANGES";                   // crsm.changes_t, of who localises
inline constexpr const char* kFleetPoseChannel = "FLEET_POSE";              // crsm.fleet_pose_t, of each robot
inline constexpr const char* kMarkChannel = "MARK";                         // crsm.mark_t, of a place with a name
inline constexpr const char* kMarkAnswerChannel = "MARK_ANSWER";            // crsm.mark_t, the same when it is kept
inline constexpr const char* kRobotMarksChannel = "ROBOT_MARKS";  // crsm.robot_marks_t, of a robot's map, for a fleet
// crsm.service_status_t, a channel for each process: so each has a row of its own in lcm-spy.
inline std::string ServiceStatusChannel(const std::string& process) { return "SERVICE_STATUS/" + process; }
inline constexpr const char* kEveryServiceStatus = "SERVICE_STATUS/*";
/// Whether a process is one of those that map, by its name.
inline bool IsOfStack(std::string_view process) {
  constexpr std::array<std::string_view, 7> kProcesses{"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater",
                                                       "loop_closer",     "map_exporter", "map_viewer"};
  return std::find(kProcesses.begin(), kProcesses.end(), process) != kProcesses.end();
}
// On which no laser can be.
inline constexpr const char* kChannelsOfStack[]{
    kOdometryChannel,  kCriticalRaysChannel, kScanMatchChannel,  kPoseChannel,       kLocalPoseChannel,
    kTruePoseChannel,  kStartPoseChannel,    kMapDeltaChannel,   kMapRequestChannel, kMapPageChannel,
    kWholeMapChannel,  kScanRequestChannel,  kScanAnswerChannel, kKeyframeChannel,   kKeyframeRequestChannel,
    kPoseGraphChannel, kFleetPoseChannel,    kChangesChannel,    kMarkChannel,       kMarkAnswerChannel,
    kRobotMarksChannel};
// In journals only.
inline constexpr const char* kJournalHeadChannel = "JOURNAL_HEAD";      // crsm.journal_head_t, the first event
inline constexpr const char* kJournalCheckChannel = "JOURNAL_CHECK";    // crsm.journal_check_t, behind each stretch
inline constexpr const char* kFleetKeyframeChannel = "FLEET_KEYFRAME";  // crsm.fleet_keyframe_t
inline constexpr const char* kFleetMarksChannel = "FLEET_MARKS";        // crsm.fleet_marks_t
inline constexpr const char* kKeptMarkChannel = "KEPT_MARK";            // crsm.kept_mark_t

}  // namespace crsm
