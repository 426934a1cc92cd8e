#include "common/graph/join_check.hpp"

#include "common/graph/submap.hpp"
#include "common/match/search/place_search.hpp"

namespace crsm {

std::optional<double> ComputeContradictionByOthers(const KeyframeGraph& graph, const GraphConstants& constants) {
  const GraphConstants::Joins& joins = constants.joins;
  const double farthest_m = constants.submaps.farthest_point_m;
  const KeyframeId newest = *graph.newest();
  const auto nearest = graph.FindNearest(graph.pose(newest), newest, newest.trajectory, joins.checked_within_m);
  if (!nearest) return std::nullopt;
  const Eigen::Matrix2Xd points_m = CollectRecentPoints(graph, newest, farthest_m, constants.submaps);
  const Pose2 initial_guess = Inverse(graph.pose(*nearest)) * graph.pose(newest);
  const Submap submap = MakeSubmap(graph, *nearest, newest, constants.submaps);
  const HitPyramid pyramid(CollectHits(graph, submap, initial_guess, farthest_m + joins.cell_m), joins.cell_m,
                           CollectRays(graph, submap, joins.seen_m, joins.shorter_m));
  const auto [on_hits, on_free] = pyramid.Lay(points_m, initial_guess);
  if (on_hits + on_free < constants.submaps.fewest_points) return std::nullopt;
  return static_cast<double>(on_free) / (on_hits + on_free);
}

void JoinCheck::Watch(const KeyframeGraph& graph) {
  trajectory_ = graph.newest()->trajectory;
  joined_m_ = graph.path_m(*graph.newest());
  next_m_ = joined_m_ + constants_.joins.every_m;
  contradicted_m_.reset();
}

bool JoinCheck::IsContradicted(const KeyframeGraph& graph) {
  const GraphConstants::Joins& joins = constants_.joins;
  const KeyframeId newest = *graph.newest();
  const double here_m = graph.path_m(newest);
  if (newest.trajectory != trajectory_ || here_m > joined_m_ + joins.checked_m) trajectory_ = -1;
  if (trajectory_ < 0 || here_m < next_m_) return false;
  next_m_ = here_m + joins.every_m;
  const auto share = ComputeContradictionByOthers(graph, constants_);
  if (!share || *share < joins.contradicted_share) return false;
  if (!contradicted_m_) contradicted_m_ = here_m;
  if (here_m - *contradicted_m_ < joins.least_apart_m) return false;
  trajectory_ = -1;
  return true;
}

}  // namespace crsm
