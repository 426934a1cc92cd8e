#pragma once

#include <Eigen/Core>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_graph.hpp"

namespace crsm {

/// Part of a trajectory, by its keyframes, both ends included. Its frame is that of the middle one. It is put together
/// by matched motions alone, which never change: the same keyframes give the same submap, whatever the graph has
/// learned since.
struct Submap {
  KeyframeId middle;
  KeyframeId first;
  KeyframeId last;
};

/// What is around a keyframe.
Submap MakeSubmapAround(const KeyframeGraph& graph, KeyframeId middle, const GraphConstants::Submaps& constants);

/// The same, but for what was driven just before the newest one.
Submap MakeSubmap(const KeyframeGraph& graph, KeyframeId middle, KeyframeId newest,
                  const GraphConstants::Submaps& constants);

/// Hits of its keyframes nearer than `farthest_m` to their laser, and to a place in the frame of the submap. 2 x N.
Eigen::Matrix2Xd CollectHits(const KeyframeGraph& graph, const Submap& submap, const Pose2& place, double farthest_m);

/// Where its rays passed, up to `farthest_m` from the laser and until `shorter_m` before they end: 4 x M, from where
/// (rows 0 and 1) to where (rows 2 and 3).
Eigen::Matrix4Xd CollectRays(const KeyframeGraph& graph, const Submap& submap, double farthest_m, double shorter_m);

/// One point of each small square, the first. 2 x N.
Eigen::Matrix2Xd ThinOut(const Eigen::Matrix2Xd& points_m, double square_m);

/// What was seen on the last metres, nearer than `farthest_m` to the laser, in the frame of the newest keyframe:
/// thinned out, and few.
Eigen::Matrix2Xd CollectRecentPoints(const KeyframeGraph& graph, KeyframeId newest, double farthest_m,
                                     const GraphConstants::Submaps& constants);

}  // namespace crsm
