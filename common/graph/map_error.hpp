#pragma once

#include <optional>
#include <vector>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/pieces.hpp"

namespace crsm {

/// How far off some trajectories that hang together may be, by all that is known of their motions: more in one map of
/// twenty.
///
/// How much worse or better each kind of edge is than FindEdges takes for granted, the residuals of the graph say, as
/// far as loops and proximity constraints tell the same motions twice (variance components: Foerstner 1979). The
/// posterior of the graph is then sampled, and each sample laid on the poses as they are, as a true path would be.
///
/// is_shown: by trajectory. Nothing for less than two keyframes, where the equations have no solution, nor where that
/// were more than any map is large.
std::optional<MapError> EstimateMapError(const KeyframeGraph& graph, const std::vector<bool>& is_shown,
                                         const GraphConstants& constants = {});

/// The step of some trajectories of which loops say most clearly that its match was wrong; nothing if none is off by
/// more than `least_m`.
std::optional<Slip> FindSlip(const KeyframeGraph& graph, const std::vector<bool>& is_shown, double least_m);

}  // namespace crsm
