#pragma once

#include "common/match/guess/tracking_state.hpp"
#include "common/match/match_constants.hpp"
#include "common/match/matcher.hpp"
#include "common/scan/critical_rays.hpp"

namespace crsm {

struct MatchOptions {
  bool loops = true;  ///< else no trajectory ever ends
  MatchConstants constants = {};
};

/// Matches a scan to the map, as MatchSweep does, and decides whether it goes on from there: where nobody knows any
/// more how the robot came here, a new trajectory begins. Such a match is kFirst. Its pose is where Matcher::Locate
/// finds the scan on the known map, far from the last one, or else a guess. It floats: nothing joins it to the map yet.
/// One scan proves nothing, so a place that was found has kUnknownVariance. Every other match is of the trajectory of
/// the last one, and floats if that does by now. The covariance of a guess is as of ComputeGuessCovariance.
///
/// A trajectory ends when scans were lost for too long, and after a gap in time, unless the robot stands where it
/// stood. With odometry over the gap it goes on. Where the clock begins anew, so may have the odometry: it does not
/// tell how the robot moved. Another drive always begins one. So does a session on an earlier map whose first scan does
/// not fit where that one ended. On a finished map, and without loops, no trajectory ever ends.
ScanMatch MatchScan(const Matcher& matcher, const CriticalRays& scan, const TrackingState& tracking,
                    const std::optional<Pose2>& T_odom_robot, const MatchOptions& options);

}  // namespace crsm
