#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "common/match/fit/scored_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/match/search/place_search.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// How far from where it is guessed a robot may be. It follows from the time since the last match, and from how fast
/// the robot moved and turned over the last ones. recent: as of TrackingState.
PlaceReach FindReach(std::span<const ScanMatch> recent, std::int64_t utime,
                     const MatchConstants::MapSearch& constants = {});

/// Where on a map a scan was found.
struct FoundOnMap {
  Pose2 T_map_laser;       ///< the best place
  double score = 0.0;      ///< as of ScorePlace; 0 where no place was found
  double runner_up = 0.0;  ///< that of the best other place
  int evaluations = 0;

  /// Whether the place fits, and clearly better than any other: rooms may be alike.
  bool IsConvincing(const MatchConstants::MapSearch& constants = {}) const {
    return score >= constants.least_found_score && runner_up <= constants.runner_up_share * score;
  }
};

/// Where a scan was taken, in a window of a map. A function of its arguments, without chance. hits_m: 2 x N, laser
/// frame, in order of rising angle.
FoundOnMap SearchMap(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const PlaceWindow& window,
                     const MatchConstants& constants = {});

/// The same on all of a map. Of one larger than 200 m x 200 m the cells are larger too.
FoundOnMap SearchWholeMap(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const MatchConstants& constants = {});

}  // namespace crsm
