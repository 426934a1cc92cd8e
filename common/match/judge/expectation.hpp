#pragma once

#include <Eigen/Core>

#include "common/match/fit/scored_map.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "common/match/match_constants.hpp"

namespace crsm {

/// What a match of this scan may be expected to reach, by the scans before: when the search may stop, and what is too
/// little to be true.
class Expectation {
 public:
  Expectation(const TrackingState& tracking, const MatchConstants& constants);

  /// The fitness at which the search stops.
  double enough() const { return enough_; }

  /// Whether nothing is known of the fitness that is usual on this map: no scan was found on it yet.
  bool unknown() const { return unknown_; }

  /// Whether the robot is followed on a finished map, at a place that is sure: a scan near there may fit worse.
  bool followed() const { return followed_; }

  /// Whether a fitness explains a scan. A scan that looks into the unknown need fit only as far as the rest can: as
  /// much as half of it where the robot goes on as before, a fifth where it may be anywhere.
  ///
  /// leniently: whether that half is granted: at a pose near the initial guess, if none further away fits better.
  /// critical_hits_m: 2 x N, laser frame, of the rays that have that fitness at `found.pose`.
  bool IsMetBy(const ScoredPose& found, bool leniently, const Eigen::Matrix2Xd& critical_hits_m,
               const ByteMap& map) const;

 private:
  MatchConstants::Acceptance constants_;
  double usual_;       ///< fitness of the last scans; on a finished map no less than its building gives
  double enough_;      ///< see enough()
  double acceptable_;  ///< share of the expected fitness below which a scan is lost
  bool unknown_;
  bool followed_;  ///< on a finished map, at a place that is sure
  bool goes_on_;   ///< the scan before was matched, so that the motion tells where this one may be
};

}  // namespace crsm
