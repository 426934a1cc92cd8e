#pragma once

#include <Eigen/Core>

#include "common/map/byte_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// Share of the rays that contradict a map, [0, 1]: they end where nothing stands, or pass through what stands. What is
/// unexplored contradicts nothing. 0 without rays. hits_m: 2 x N, where they end, laser frame.
double ComputeContradiction(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                            const MatchConstants::Contradiction& constants = {});

}  // namespace crsm
