#pragma once

#include <optional>

#include "common/match/match_constants.hpp"
#include "common/match/matcher.hpp"

namespace crsm {

/// Matches a scan whose beams were measured one after the other, by any matcher: it is deskewed by how the laser moved
/// last, matched, and as long as the match says that it moved otherwise and fits better so, deskewed by that and
/// matched once more. Where it does not fit as scans usually do, the laser may have stopped, or begun to turn: that is
/// tried then. The match says by which twist the scan was deskewed. What was measured at once is matched, and no more.
ScanMatch MatchSweep(const Matcher& matcher, const CriticalRays& scan, const TrackingState& tracking,
                     const std::optional<Pose2>& T_odom_robot, const MatchConstants& constants = {});

}  // namespace crsm
