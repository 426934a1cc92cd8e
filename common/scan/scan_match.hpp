#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/math/pose2.hpp"
#include "common/scan/wheel_motion.hpp"

namespace crsm {

inline constexpr double kFastest = 20.0;  ///< that any laser moves [m/s] or turns [rad/s]

inline constexpr double kUnknownVariance = 1e4;  ///< variance of a pose of which nothing is known [m^2 and rad^2]
inline constexpr std::array<double, 6> kUnknownCovariance{kUnknownVariance, 0.0, 0.0,
                                                          kUnknownVariance, 0.0, kUnknownVariance};

/// How a laser moves, in its own frame.
struct Twist {
  double x_m_s = 0.0;
  double y_m_s = 0.0;
  double yaw_rad_s = 0.0;

  friend bool operator==(const Twist&, const Twist&) = default;
};

enum class MatchState : std::int8_t {
  kFirst = 0,       ///< a trajectory begins: the pose is the origin, or a guess where nobody knows
  kOk = 1,          ///< matched: the scan goes into the map
  kLost = 2,        ///< no pose explains the scan: the pose is a guess, the scan stays out of the map
  kDegenerate = 3,  ///< matched, but nothing seen holds the position along one axis, as in a bare corridor
};

/// Where the laser stood when it took a scan, and how that was found.
struct ScanMatch {
  std::int64_t utime = 0;  ///< the scan's
  Pose2 T_map_laser;
  double fitness = 0.0;           ///< of the critical rays at that pose, [0, 1]
  std::int32_t evaluations = 0;   ///< fitness evaluations spent
  std::int32_t num_critical = 0;  ///< critical rays matched
  std::int64_t map_version = 0;   ///< of the map that the scan was matched against; 0 = empty, or a finished map
  MatchState state = MatchState::kFirst;
  std::int32_t best_evaluation = 0;  ///< the one that found the best pose; 0 where none was needed
  /// xx, xy, x yaw, yy, y yaw, yaw yaw [m^2, m rad, rad^2]. 0 in the first scan of all, which is the origin. Of a
  /// guess, lost or first, as of ComputeGuessCovariance.
  std::array<double, 6> covariance{};
  std::array<double, 2> degenerate_axis{};           ///< unit vector, map frame, where the state is kDegenerate; else 0
  std::optional<Pose2> T_odom_robot = std::nullopt;  ///< by odometry, where there is some and it is to be used
  Twist twist =
      {};  ///< by which the scan was deskewed; 0 where nothing is known of it, or all beams are measured at once
  std::int32_t trajectory = 0;  ///< which unbroken run of scans it is of, from 0
  bool floating = false;        ///< that trajectory is not joined to the map that is shown: its frame is its own
  /// Since the last scan, where the wheels are believed.
  std::optional<WheelMotion> by_wheels = std::nullopt;

  friend bool operator==(const ScanMatch&, const ScanMatch&) = default;
};

/// Whether the motion between two scans that follow each other was matched: none was lost, and no trajectory begins.
inline bool IsMotionMatched(const ScanMatch& from, const ScanMatch& to) {
  return from.state != MatchState::kLost && to.state != MatchState::kLost && to.state != MatchState::kFirst;
}

}  // namespace crsm
