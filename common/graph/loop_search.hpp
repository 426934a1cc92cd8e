#pragma once

#include <optional>
#include <vector>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/loop_finding.hpp"
#include "common/graph/submap.hpp"
#include "common/map/map_updater.hpp"
#include "common/match/match_constants.hpp"

namespace crsm {

/// What the search takes for granted.
struct LoopSearchConstants {
  GraphConstants graph = {};
  MatchConstants match = {};
};

/// Looks for the newest keyframe in submaps of the path long ago: those between which and the newest one the graph does
/// not vouch for the poses. It looks `thoroughly` wherever the poses may have drifted to, and where there are no such
/// submaps once more where the matches say that the robot is; else only as far as they drift as a rule, which costs
/// much less. Nothing where no place fits, or another one, however far, fits nearly as well.
std::optional<LoopFinding> SearchLoop(const KeyframeGraph& graph, double local_map_m, bool thoroughly,
                                      const LoopSearchConstants& constants);

/// The loop of a finding, its pose refined on a map of the submap; nothing if the rays of the newest keyframe would run
/// through walls there.
std::optional<Loop> MakeLoop(const KeyframeGraph& graph, const LoopFinding& finding, const DrawingRules& drawing,
                             const LoopSearchConstants& constants);

/// Where something was found, and who found it: the graph of a submap, and that of the newer keyframe, which may be
/// another one.
struct FoundIn {
  const KeyframeGraph& older;
  const Submap& submap;
  const KeyframeGraph& newer;
};
/// The same, of a finding between two graphs.
std::optional<Loop> MakeLoop(const FoundIn& place, const LoopFinding& finding, const DrawingRules& drawing,
                             const LoopSearchConstants& constants);

/// Whether a keyframe is of another trajectory than the newest one, or further back than `long_ago_m`.
inline bool IsLongAgo(const KeyframeGraph& graph, KeyframeId id, double long_ago_m) {
  const KeyframeId newest = *graph.newest();
  return id.trajectory != newest.trajectory || graph.path_m(newest) - graph.path_m(id) > long_ago_m;
}

}  // namespace crsm
