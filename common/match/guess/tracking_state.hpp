#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/match/guess/wheel_model.hpp"
#include "common/match/match_constants.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// How the robot came to where the next scan is taken.
enum class Onset : std::int8_t {
  kGoesOn = 0,    ///< it drove on from the last scan
  kResumed = 1,   ///< a session begins on the map of an earlier one: it may stand where that one ended
  kNear = 2,      ///< another drive begins, near a place that is known
  kAnywhere = 3,  ///< another drive begins, and nothing is known of its place
};

/// What a match has brought about.
struct AfterMatch {
  std::optional<Pose2> T_new_old = std::nullopt;  ///< by which robot and map have moved, where the map was corrected
  std::int32_t trajectory = 0;                    ///< the newest one, from 0
  bool floating = false;  ///< by now that is not joined to the map that is shown: its poses are in a frame of its own

  friend bool operator==(const AfterMatch&, const AfterMatch&) = default;
};

/// All that a matcher remembers of the scans before: of one size, however long the robot drives. The map's owner keeps
/// it beside the map, so that a matcher that is started anew goes on where the last one stood.
class TrackingState {
 public:
  static constexpr std::size_t kRecent = 10;  ///< as many as motion prediction looks back
  static constexpr std::size_t kUsual = 10;   ///< matched scans whose fitness is the usual one

  TrackingState() = default;
  /// constants: by which it learns. They do not travel.
  explicit TrackingState(const MatchConstants& constants);

  /// Before the first scan on a map that was there already: the robot may be anywhere on it.
  static TrackingState OnFinishedMap(const MatchConstants& constants = {});

  /// The next scan was matched, or lost, and drawn into the map. What follows a scan that is not lost goes on from
  /// there. Where the map has moved, what was at T_old is at T_new_old * T_old. Of the matches it takes the poses
  /// along; nothing is predicted from their covariances and axes, which stay as they were found.
  void Add(const ScanMatch& match, const AfterMatch& after);
  /// The same where the map stayed as it is, and the match says what its trajectory is.
  void Add(const ScanMatch& match) { Add(match, {std::nullopt, match.trajectory, match.floating}); }

  /// A session begins on this map. onset: kResumed or kAnywhere.
  void BeginSession(Onset onset);
  /// The same; the robot stands near T_map_laser.
  void BeginSessionNear(const Pose2& T_map_laser);
  /// The same state of a robot of which somebody says that it stands at T_map_laser, and stands still. Before the first
  /// scan nothing changes.
  TrackingState MovedTo(const Pose2& T_map_laser) const;
  Onset onset() const { return onset_; }
  /// With kNear the place that is known, with kAnywhere that of the last scan.
  const Pose2& T_map_guess() const { return T_map_guess_; }

  /// From the map frame to one that does not move when the map does, but drifts away from it, as REP 105's odom.
  const Pose2& T_local_map() const { return T_local_map_; }

  /// Before the first scan.
  bool empty() const { return num_scans_ == 0; }
  std::int64_t num_scans() const { return num_scans_; }
  bool on_finished_map() const { return on_finished_map_; }

  /// How many of the last scans were lost in a row.
  std::int64_t num_lost() const { return num_lost_; }

  /// Mean fitness of the last scans that were matched; 0 while there are none.
  double baseline_fitness() const;

  /// The last matches, oldest first; at most kRecent.
  std::span<const ScanMatch> recent() const { return recent_; }
  /// Of the last scans that were matched, oldest first; at most kUsual.
  std::span<const double> fitnesses() const { return fitnesses_; }

  /// Of the newest scan, from 0; 0 before the first.
  std::int32_t trajectory() const { return trajectory_; }
  /// Whether by now that trajectory is not joined to the map that is shown.
  bool floating() const { return floating_; }

  /// What the wheels are worth, by the matches so far.
  const WheelModel& wheels() const { return wheels_; }

  /// How far the motion before told the next scan's place wrongly, on average of the scans so far: how unevenly the
  /// robot drives.
  double motion_error_m() const { return motion_error_m_; }

  /// The utime of the newest scan so far, by its own clock; -1 before the first.
  std::int64_t newest_utime() const { return newest_utime_; }

  /// The match of a scan among the recent ones; nullptr if it is not there.
  const ScanMatch* FindRecent(std::int64_t utime) const;

  /// Its parts, as they travel.
  struct Parts {
    std::int64_t num_scans = 0;
    std::int64_t num_lost = 0;
    std::int64_t newest_utime = -1;
    bool on_finished_map = false;
    std::vector<double> fitnesses;  ///< the last kUsual of more
    std::vector<ScanMatch> recent;  ///< the last kRecent of more
    Pose2 T_local_map;
    Onset onset = Onset::kGoesOn;
    Pose2 T_map_guess;
    std::int32_t trajectory = 0;
    bool floating = false;
    WheelModel wheels;
    double motion_error_m = MatchConstants::Tracking{}.first_motion_error_m;
  };
  explicit TrackingState(Parts parts);

  friend bool operator==(const TrackingState&, const TrackingState&) = default;

 private:
  void LearnMotionError(const ScanMatch& match);
  void Move(const Pose2& T_new_old);

  MatchConstants::Tracking constants_;
  MatchConstants::Prediction prediction_;
  std::int64_t num_scans_ = 0;
  std::int64_t num_lost_ = 0;
  std::int64_t newest_utime_ = -1;
  bool on_finished_map_ = false;
  std::vector<double> fitnesses_;
  std::vector<ScanMatch> recent_;
  Pose2 T_local_map_;
  Onset onset_ = Onset::kGoesOn;
  Pose2 T_map_guess_;
  std::int32_t trajectory_ = 0;
  bool floating_ = false;
  WheelModel wheels_;
  double motion_error_m_ = constants_.first_motion_error_m;
};

}  // namespace crsm
