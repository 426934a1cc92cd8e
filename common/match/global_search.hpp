#pragma once

#include <Eigen/Core>

#include "common/match/match_constants.hpp"
#include "common/match/scored_map.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

// Where on a map a scan was taken, when nothing is known of that. Each is a function of its arguments, without chance.
// hits_m: 2 x N, laser frame, in order of rising angle.

/// Share of the rays that go through the map as they went through the building, [0, 1]: over cells that are not
/// occupied, to an occupied one. Fitness asks only where rays end; this tells a room from another one that has its
/// walls and more. 0 without rays.
double ComputeAgreement(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                        const MatchConstants::Agreement& constants = {});

/// How well a scan fits a place: its fitness there times its agreement, [0, 1].
double ScorePlace(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                  const MatchConstants& constants = {});

/// What a search of the whole map has found.
struct GlobalMatch {
  Pose2 T_map_laser;       ///< the best place
  double score = 0.0;      ///< as of ScorePlace; 0 where no place was found
  double runner_up = 0.0;  ///< that of the best other place: 0.5 m or 0.26 rad away
  int evaluations = 0;     ///< of the fitness

  /// Whether the place fits, and clearly better than any other: rooms may be alike.
  bool IsConvincing(const MatchConstants::GlobalSearch& constants = {}) const {
    return score >= constants.least_score && runner_up <= constants.runner_up_share * score;
  }
};

/// Finds where on the whole map a scan was taken.
///
/// critical_hits_m: those of the critical rays. Every free place, 0.2 m from the next, is tried in 120 directions on a
/// map of cells as large; the best of them climb on finer and finer maps, and on the highest the rays are followed
/// through the map. Where there are more than 10,000 places, on 400 m2, the first cells are larger, 0.4 m and so on, so
/// that it takes no longer: two million evaluations, a quarter of a second. Cells of 0.4 m found as much as those of
/// 0.2 m on three maps of buildings; cells of 0.8 and 1.6 m found a tenth less.
GlobalMatch SearchWholeMap(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m,
                           const Eigen::Matrix2Xd& critical_hits_m, const MatchConstants& constants = {});

}  // namespace crsm
