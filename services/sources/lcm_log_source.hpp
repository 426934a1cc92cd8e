#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/diagnosis/handedness.hpp"
#include "common/logs/laser_source.hpp"
#include "common/logs/log_clock.hpp"
#include "common/parameters.hpp"
#include "services/diagnosis/laser_frames.hpp"
#include "services/sources/laser_choice.hpp"
#include "services/sources/scans_with_odometry.hpp"
#include "services/wire/laser_types.hpp"
#include "services/wire/lcm_event_log.hpp"

namespace crsm {

/// Scans of an LCM log, plain or compressed by gzip, in the log's order. A message is a laser's by its type, whatever
/// its channel; lasers/ has the types that are known.
///
/// Odometry: from the ODOMETRY messages (pose_types.hpp) on the channel with the laser's prefix, or from the channel
/// that is named: that of the scan's own utime or between the two around it (ScansWithOdometry).
///
/// A scan has its utime where that can be microseconds and tells scans apart (LogClock); else the time at which it was
/// recorded, or a number. Where the beams have no times, and the times of recording show that a utime is that of the
/// first beam of a sweep, it becomes that of the last one (SweepStamps).
///
/// Poses that others have left in the log, on whatever channel, tell whether the scans are mirrored: a complaint says
/// so.
///
/// Counted and skipped: "bad_message" (arrays that do not fill the message, beams outside 2..4096, angles that are
/// none, a message on the laser's channel that is no laser's), "utime_repeated" (the utime of an earlier scan),
/// "other_channel" (a laser's message on a channel other than the chosen), "other_frame" (of another laser there),
/// "bad_odometry" (numbers that are none), "bad_event" (damaged stretches of the log). Also counted: "truncated" (the
/// log ends within an event; what was whole is used).
class LcmLogSource : public LaserSource {
 public:
  /// laser: whose scans to take. Throws std::runtime_error that lists the channels if there is no such one, or the
  /// frames of the scans if they do not tell which. odometry: its channel; empty for the usual one. Throws too if no
  /// message on the channel that it names is a pose.
  LcmLogSource(const std::string& path, const LaserChoice& laser, const LaserMessageOptions& messages = {},
               const std::string& odometry = "");

  std::optional<LaserScan> Next() override;
  std::optional<Pose2> Odometry() const override { return scans_.T_odom_robot(); }
  std::string OdometryName() const override { return scans_.num_with_odometry() > 0 ? odometry_channel_ : ""; }
  double Progress() const override { return log_.Progress(); }
  std::string Channel() const override { return channel_; }
  std::map<std::string, std::int64_t> Counts() const override;
  std::vector<std::string> Complaints() const override;
  std::vector<std::string> OdometryNotes() const override;

 private:
  void StudyFirstScans(const std::string& path, const std::string& wanted);
  /// Takes what the next event says; false at the end of the log.
  bool ReadEvent();
  void TakePose(const std::string& channel, std::string_view data);
  void TakeScan(const LcmEventLog::Event& event);

  LaserMessageOptions messages_;
  LcmEventLog log_;
  std::string channel_;
  LaserFrames frames_;
  std::string odometry_channel_;
  std::map<std::string, std::int64_t> counts_;
  std::set<std::string> other_channels_;               ///< that have a laser, too
  std::string first_refusal_;                          ///< what is wrong with the first bad message
  std::string thinned_;                                ///< as of ThinBeams
  std::string contradiction_;                          ///< in the first message that has one
  const LaserType* laser_ = nullptr;                   ///< the type of the scans' messages
  std::map<std::string, HandednessJudge> handedness_;  ///< by the channel of the poses
  LogClock clock_;
  std::int64_t sweep_us_ = 0;  ///< from the stamp to the last beam, where the stamp is that of the first one
  ScansWithOdometry scans_;
};

}  // namespace crsm
