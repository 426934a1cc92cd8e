#include "common/graph/submap.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <vector>

#include "common/math/columns.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

/// Calls `visit` with the pose of each keyframe in the frame of the submap, and its hits in the laser's frame.
template <class Visit>
void VisitScans(const KeyframeGraph& graph, const Submap& submap, Visit&& visit) {
  Pose2 T_submap_at = graph.Motion(submap.middle, submap.first);
  for (KeyframeId at = submap.first; at <= submap.last; ++at.number) {
    if (at > submap.first) T_submap_at = T_submap_at * graph.keyframe(at).T_previous_this;
    visit(T_submap_at, ComputeHits(graph.keyframe(at).rays.Unpack()));
  }
}

}  // namespace

Submap MakeSubmapAround(const KeyframeGraph& graph, KeyframeId middle, const GraphConstants::Submaps& constants) {
  const double middle_m = graph.path_m(middle);
  return {middle, graph.FindByPath(middle.trajectory, middle_m - constants.reach_m),
          graph.FindByPath(middle.trajectory, middle_m + constants.reach_m)};
}

Submap MakeSubmap(const KeyframeGraph& graph, KeyframeId middle, KeyframeId newest,
                  const GraphConstants::Submaps& constants) {
  Submap submap = MakeSubmapAround(graph, middle, constants);
  submap.last = std::min(submap.last, graph.FindByPath(newest.trajectory, graph.path_m(newest) - constants.long_ago_m));
  return submap;
}

Eigen::Matrix2Xd CollectHits(const KeyframeGraph& graph, const Submap& submap, const Pose2& place, double farthest_m) {
  const Eigen::Vector2d place_m(place.x_m, place.y_m);
  std::vector<Eigen::Vector2d> all;
  VisitScans(graph, submap, [&](const Pose2& laser, const Eigen::Matrix2Xd& hits_m) {
    const auto [sin, cos] = ComputeSinCos(laser.yaw_rad);
    for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
      const Eigen::Vector2d hit_m(laser.x_m + cos * hits_m(0, i) - sin * hits_m(1, i),
                                  laser.y_m + sin * hits_m(0, i) + cos * hits_m(1, i));
      const double distance2_m2 = std::max(hits_m.col(i).squaredNorm(), (hit_m - place_m).squaredNorm());
      if (distance2_m2 < farthest_m * farthest_m) all.push_back(hit_m);
    }
  });
  return JoinColumns<Eigen::Matrix2Xd>(all);
}

Eigen::Matrix4Xd CollectRays(const KeyframeGraph& graph, const Submap& submap, double farthest_m, double shorter_m) {
  std::vector<Eigen::Vector4d> all;
  VisitScans(graph, submap, [&](const Pose2& laser, const Eigen::Matrix2Xd& hits_m) {
    const auto [sin, cos] = ComputeSinCos(laser.yaw_rad);
    for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
      const double range_m = hits_m.col(i).norm();
      const double share = std::min(range_m - shorter_m, farthest_m) / range_m;
      if (share <= 0.0) continue;
      const Eigen::Vector2d end_m = share * hits_m.col(i);
      all.emplace_back(laser.x_m, laser.y_m, laser.x_m + cos * end_m.x() - sin * end_m.y(),
                       laser.y_m + sin * end_m.x() + cos * end_m.y());
    }
  });
  return JoinColumns<Eigen::Matrix4Xd>(all);
}

Eigen::Matrix2Xd ThinOut(const Eigen::Matrix2Xd& points_m, double square_m) {
  std::unordered_set<std::int64_t> taken;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    const auto x = static_cast<std::int64_t>(std::floor(points_m(0, i) / square_m));
    const auto y = static_cast<std::int64_t>(std::floor(points_m(1, i) / square_m));
    if (taken.insert(x * (std::int64_t{1} << 32) + y).second) kept.push_back(i);
  }
  return points_m(Eigen::all, kept);
}

Eigen::Matrix2Xd CollectRecentPoints(const KeyframeGraph& graph, KeyframeId newest, double farthest_m,
                                     const GraphConstants::Submaps& constants) {
  const KeyframeId first = graph.FindByPath(newest.trajectory, graph.path_m(newest) - constants.recent_m);
  const Eigen::Matrix2Xd hits_m = CollectHits(graph, {newest, first, newest}, {}, farthest_m);
  const Eigen::Matrix2Xd all_m = ThinOut(hits_m, constants.square_m);
  Eigen::Matrix2Xd points_m(2, std::min<Eigen::Index>(all_m.cols(), constants.most_points));
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) points_m.col(i) = all_m.col(i * all_m.cols() / points_m.cols());
  return points_m;
}

}  // namespace crsm
