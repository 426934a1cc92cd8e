#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/pieces.hpp"
#include "common/match/match_constants.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// How well the walls told where a keyframe was taken on the map: standard deviations.
struct WallSigma {
  std::array<double, 2> axis{1.0, 0.0};  ///< unit vector, laser frame: along it they told least
  MotionSigma sigma{};                   ///< along that axis, across it, and of the yaw
  /// Along a degenerate direction without what the noise of the normals makes of straight walls; infinite if that was
  /// all.
  double along_m = 0.0;
};

/// Of a match that was not lost: its covariance, without what the map itself is good for.
WallSigma FindWallSigma(const ScanMatch& match, const MatchConstants::Uncertainty& constants = {},
                        double cell_size_m = 0.05);

/// By trajectory and number of the keyframe.
using WallSigmas = std::vector<std::vector<WallSigma>>;

/// How far off some trajectories that hang together may be, by all that is known of their motions: more in one map of
/// twenty.
///
/// A motion is as uncertain as what held its match: walls (Censi 2007), wheels as they were learned, or along a
/// degenerate direction how the robot drives. Where it seems to be slower or faster there than it usually is, it may
/// as well have gone on as usual. How much worse or better each kind of these is than was taken for granted, the
/// residuals of the graph say, as far as loops and proximity constraints tell the same motions twice (variance
/// components: Foerstner 1979). The posterior of the graph is then sampled, and each sample laid on the poses as they
/// are, as a true path would be.
///
/// is_shown: by trajectory. Nothing for less than two keyframes, where the equations have no solution, nor where that
/// were more than any map is large.
std::optional<MapError> EstimateMapError(const KeyframeGraph& graph, const std::vector<bool>& is_shown,
                                         const WallSigmas& walls, const GraphConstants::MapError& constants = {});

}  // namespace crsm
