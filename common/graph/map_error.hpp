#pragma once

#include <optional>
#include <vector>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_edges.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/pieces.hpp"

namespace crsm {

/// What is known of the poses of some trajectories: no scans, so that it is small.
struct KnownMotions {
  struct Edge {
    int from;  ///< index of a pose
    int to;
    KeyframeEdge edge;
  };

  std::vector<Pose2> poses;
  std::vector<Edge> edges;

  /// Adds trajectories of a graph. poses: T_map_keyframe of all its keyframes. is_taken: by trajectory. Returns the
  /// index of each trajectory's first pose.
  std::vector<int> Add(const KeyframeGraph& graph, const KeyframePoses& poses_of_graph,
                       const std::vector<bool>& is_taken, const GraphConstants::Edges& constants);
};

/// How far off trajectories that hang together may be, by all that is known of their motions: more in one map of
/// twenty.
///
/// The posterior of the graph is sampled, and each sample laid on the poses as they are, as a true path would be.
///
/// Nothing for less than two keyframes, where the equations have no solution, nor where that were more than any map is
/// large. with_way_back: also which drive would tell most, where the map may be far off; takes some tenths of a second.
std::optional<MapError> EstimateMapError(const KnownMotions& motions, const GraphConstants& constants = {},
                                         bool with_way_back = true);

/// The step of some trajectories of which loops say most clearly that its match was wrong; nothing if none is off by
/// more than `least_m`.
///
/// poses: T_map_keyframe of all keyframes. is_shown: by trajectory.
std::optional<Slip> FindSlip(const KeyframeGraph& graph, const KeyframePoses& poses, const std::vector<bool>& is_shown,
                             double least_m);

}  // namespace crsm
