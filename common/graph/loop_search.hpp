#pragma once

#include <optional>
#include <vector>

#include "common/graph/keyframe_graph.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// The robot is where it was long ago, by what its laser saw on the last metres of its path.
struct LoopFinding {
  KeyframeId older;     ///< the middle keyframe of the submap in which it was found
  KeyframeId newer;     ///< the newest keyframe
  Pose2 T_older_newer;  ///< to within a cell
  double score = 0.0;   ///< share of the points that lie on hits of the submap, [0, 1]
  bool known = false;   ///< the graph vouches for that place, and matches were made on it already
};

/// Looks for the newest keyframe in submaps of the path long ago: those between which and the newest one the graph does
/// not vouch for the poses. It looks `thoroughly` wherever the poses may have drifted to, and where there are no such
/// submaps once more where the matches say that the robot is; else only as far as they drift as a rule, which costs
/// much less. Nothing where no place fits, or another one, however far, fits nearly as well.
///
/// Submaps and points are put together by matched motions alone, which never change: the same keyframes give the same
/// submaps, whatever the graph has learned since.
std::optional<LoopFinding> SearchLoop(const KeyframeGraph& graph, double local_map_m, bool thoroughly);

/// Looks for the newest keyframe, in any direction, in all that hangs together with it by nothing. Nothing where no
/// place fits, or another place of the same component fits nearly as well.
std::optional<LoopFinding> SearchElsewhere(const KeyframeGraph& graph);

/// The loop of a finding, its pose refined on a map of the submap; nothing if the rays of the newest keyframe would run
/// through walls there.
std::optional<Loop> MakeLoop(const KeyframeGraph& graph, const LoopFinding& finding, const UpdateParameters& drawing);

/// What was on the path so long ago is looked for [m]: what is nearer is in every map that is matched against.
inline constexpr double kLongAgo_m = 25.0;

/// Whether a keyframe is of another trajectory than the newest one, or so long ago.
inline bool IsLongAgo(const KeyframeGraph& graph, KeyframeId id) {
  const KeyframeId newest = *graph.newest();
  return id.trajectory != newest.trajectory || graph.path_m(newest) - graph.path_m(id) > kLongAgo_m;
}

}  // namespace crsm
