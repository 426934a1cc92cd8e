#pragma once

#include <array>

#include "common/graph/pose_graph.hpp"
#include "common/match/match_constants.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// How well the walls told where a keyframe was taken on the map: standard deviations.
struct WallSigma {
  std::array<double, 2> axis{1.0, 0.0};  ///< unit vector, laser frame: along it they told least
  MotionSigma sigma{0.01, 0.01, 0.002};  ///< along that axis, across it, and of the yaw; as it is where walls are near
  friend bool operator==(const WallSigma&, const WallSigma&) = default;
};

/// Of a match that was not lost: its covariance, without what the map itself is good for.
WallSigma FindWallSigma(const ScanMatch& match, const MatchConstants::Uncertainty& constants = {},
                        double cell_size_m = 0.05);

}  // namespace crsm
