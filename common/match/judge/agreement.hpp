#pragma once

#include <Eigen/Core>

#include "common/match/fit/scored_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// Share of the rays that go through the map as they went through the building, [0, 1]: over cells that are not
/// occupied, to an occupied one. Fitness asks only where rays end; this tells a room from another one that has its
/// walls and more. 0 without rays. hits_m: 2 x N, laser frame.
double ComputeAgreement(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                        const MatchConstants::Agreement& constants = {});

/// How well a scan fits a place: its fitness there times its agreement, [0, 1].
double ScorePlace(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                  const MatchConstants& constants = {});

}  // namespace crsm
