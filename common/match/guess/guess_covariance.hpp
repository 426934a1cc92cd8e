#pragma once

#include <array>

#include "common/match/guess/tracking_state.hpp"
#include "common/match/match_constants.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// The usual one: the graph's constants of the search near a break begin as this.
inline constexpr MatchConstants::GuessWindow kGuessWindow;

/// How well a pose is known that is a guess: that of a lost scan, or of the first one of a trajectory, on the map of
/// the trajectory before it. As of ScanMatch::covariance, the same in all directions.
///
/// Standard deviations are half of the window, without a limit to the time: with each second since the last match
/// they grow by as much as its half does, or by what the robot moved in a second when it was matched last, if that is
/// more. Where the wheels are believed they grow by what those are worth instead. They end at 50 m, and
/// at what any heading has; so does a guess after a clock that begins anew: nobody knows the time between.
///
/// kUnknownVariance where there is nothing to guess from: in another drive that begins anywhere, and on a finished map
/// before the first match. tracking: before the scan of the match.
std::array<double, 6> ComputeGuessCovariance(const ScanMatch& guess, const TrackingState& tracking,
                                             const MatchConstants::GuessWindow& constants = {});

}  // namespace crsm
