#pragma once

#include <optional>
#include <span>

#include "common/parameters.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// Where to look for a scan before it is matched: the last pose, or the last motions repeated (section 5.3,
/// "the presumed new robot transformation, based on the speed or the kinematic model").
///
/// recent: the last matches, oldest first; at least one, and more than ten change nothing. Lasers turn steadily and
/// loggers stamp unsteadily: a motion is one from scan to scan, whatever the times say. The pose of a lost scan is a
/// guess and tells no speed.
Pose2 PredictPose(std::span<const ScanMatch> recent, const MatchParameters& parameters);

/// How steady a motion is until `utime`: 1 up to 0.3 s after the last match, later less with the square of the time, in
/// which a robot becomes faster or slower. 1 if there was no match: the pose is not presumed by a motion.
double ComputeSteadiness(std::span<const ScanMatch> recent, std::int64_t utime);

/// Where the robot is if it went on as before while its last scans were lost, five at most. Nothing if none was lost,
/// or how it moved before that is not known.
std::optional<Pose2> ContinueMotion(std::span<const ScanMatch> recent, const MatchParameters& parameters);

/// The same by time, however many scans were lost, for 6 s at most: as the robot moved between the last two scans that
/// were matched one after the other, but straighter. The last pose where that is not known.
Pose2 GuessOnward(std::span<const ScanMatch> recent, std::int64_t utime);

/// The same by odometry: the last pose and the motion of the wheels since. Nothing if that is not to be trusted: when
/// there was no odometry at either scan, when it jumps further than a robot drives in that time, or when it told the
/// last motions worse than PredictPose did.
///
/// recent: as of PredictPose; more than ten change nothing. utime, T_odom_robot: of the scan. The laser is taken to
/// stand at the robot's centre; what that costs is its distance from there times the turn between two scans.
std::optional<Pose2> PredictPoseByOdometry(std::span<const ScanMatch> recent, std::int64_t utime,
                                           const std::optional<Pose2>& T_odom_robot, const MatchParameters& parameters);

}  // namespace crsm
