#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/graph/keyframe_graph.hpp"

namespace crsm {

enum class ToldBy : std::uint8_t { kMatch, kProximity, kLoop, kWheels };

/// Where a keyframe is, seen from an older one.
struct KeyframeEdge {
  KeyframeId older;
  KeyframeId newer;
  Pose2 T_older_newer;
  MotionSigma sigma;  ///< along x_axis, across it, and of the yaw
  ToldBy told_by;
  std::array<double, 2> x_axis = {1.0, 0.0};  ///< unit vector, frame of `older`

  /// A loop may be of another place, and wheels slip.
  bool may_be_wrong() const { return told_by == ToldBy::kLoop || told_by == ToldBy::kWheels; }
};

KeyframeEdge MakeEdge(const Loop& loop, const GraphConstants::Edges& constants);

/// from, to: where a pose graph has the older keyframe, and the newer one.
GraphEdge ToGraphEdge(const KeyframeEdge& edge, int from, int to);

/// All that a graph knows of its motions, but for breaks that nothing bridges: by the names of the newer keyframes, and
/// the loops behind them.
///
/// A match is as uncertain as what held it: walls (Censi, "An accurate closed-form estimate of ICP's covariance", ICRA
/// 2007), or along a degenerate direction how the robot drives. Where it seems to be slower or faster there than it
/// usually is, it may as well have gone on as usual.
std::vector<KeyframeEdge> FindEdges(const KeyframeGraph& graph, const GraphConstants::Edges& constants);

}  // namespace crsm
