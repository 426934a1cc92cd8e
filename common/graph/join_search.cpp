#include "common/graph/join_search.hpp"

#include <algorithm>
#include <cmath>

#include "common/graph/submap.hpp"

namespace crsm {
namespace {

/// From the end of one trajectory to the beginning of the next [s].
double ComputeBreak(const KeyframeGraph& graph, int before) {
  const auto utime = [&](KeyframeId id) { return static_cast<double>(graph.keyframe(id).utime); };
  return 1e-6 * std::abs(utime({before + 1, 0}) - utime(graph.LastOf(before)));
}

/// The keyframe nearest to where the newest trajectory is guessed to begin: the last one before it, unless the guess is
/// further than `far_m` from there, as where the user says where the robot stands.
KeyframeId FindNearest(const KeyframeGraph& graph, double far_m) {
  const KeyframeId first{graph.newest()->trajectory, 0};
  const KeyframeId last = *graph.Before(first);
  if (Distance(graph.pose(last), graph.pose(first)) <= far_m) return last;
  return graph.FindNearest(graph.pose(first), last, first.trajectory, HUGE_VAL).value_or(last);
}

/// How far the newest keyframe may be from where it is guessed to be, since the end of a trajectory before a break.
PlaceReach FindReach(const KeyframeGraph& graph, KeyframeId last, double between_s,
                     const GraphConstants::Joins& joins) {
  const auto bridges = graph.SumBridges(last, *graph.newest());
  if (!bridges) return {joins.nearby_m + joins.m_per_s * between_s, joins.nearby_rad + joins.rad_per_s * between_s};
  return {joins.bridged_m + joins.bridged_sigmas * bridges->sigma_m,
          joins.bridged_rad + joins.bridged_sigmas * bridges->sigma_rad};
}

}  // namespace

std::optional<LoopFinding> JoinSearch::Search(const KeyframeGraph& graph, const std::vector<KeyframeId>& found_before) {
  const GraphConstants::Joins& joins = constants_.joins;
  const auto nearby = SearchNearby(graph);
  if (nearby && nearby->by == LoopFinding::By::kSoon) return nearby;
  const std::vector<KeyframeId> middles = FindMiddles(graph);
  if (middles.empty()) return nearby;
  const double farthest_m = constants_.submaps.farthest_point_m;
  const Eigen::Matrix2Xd points_m = CollectRecentPoints(graph, *graph.newest(), farthest_m, constants_.submaps);
  if (points_m.cols() < constants_.submaps.fewest_points) return std::nullopt;
  const LineSpectrum spectrum = ComputeLineSpectrum(points_m, match_.line_spectrum);
  BestFinding best(graph, constants_.submaps, LoopFinding::By::kAnywhere);
  if (nearby) best.Add(nearby->older, {nearby->T_older_newer, nearby->score});
  const auto SearchIn = [&](KeyframeId middle) {
    const DrawnSubmap& submap = Draw(graph, middle);
    const Turns turns = FindBestTurns(submap.spectrum, spectrum, joins.num_turns);
    const Place place = FindPlace(submap.pyramid, points_m, {{}, joins.reach_m, kPi, turns},
                                  {farthest_m, best.LeastScore(joins.least_score), constants_.submaps.rival_share,
                                   joins.most_evaluations, match_.map_search.other_place});
    if (place.evaluations <= joins.most_evaluations) best.Add(middle, place);
  };
  const auto [now, later] = TakeTurns(graph, middles, found_before);
  std::ranges::for_each(now, SearchIn);
  if (!best.Unrivalled()) return std::nullopt;
  std::ranges::for_each(later, SearchIn);  // is there another one like it?
  const auto found = best.Unrivalled();
  return found && nearby && found->older == nearby->older ? nearby : found;
}

/// Soon after a break the robot is near where it was before it, unless it was carried: less has to fit there than in a
/// window of any size.
std::optional<LoopFinding> JoinSearch::SearchNearby(const KeyframeGraph& graph) const {
  const GraphConstants::Joins& joins = constants_.joins;
  const KeyframeId newest = *graph.newest();
  double way_m = graph.path_m(newest);
  if (newest.trajectory == 0 || way_m > joins.soon_m) return std::nullopt;
  if (graph.keyframe({newest.trajectory, 0}).begins_anywhere) return std::nullopt;
  const Eigen::Matrix2Xd points_m = CollectRecentPoints(graph, newest, joins.nearby_point_m, constants_.submaps);
  if (points_m.cols() < constants_.submaps.fewest_points) return std::nullopt;
  BestFinding best(graph, constants_.submaps, LoopFinding::By::kNearby);
  double between_s = 0.0;
  for (int before = newest.trajectory - 1; before >= 0 && way_m < joins.back_m; --before) {
    const KeyframeId last = graph.LastOf(before);
    between_s += ComputeBreak(graph, before);
    way_m += graph.path_m(last);
    if (graph.HangTogether(last, newest)) continue;
    const KeyframeId nearest = before + 1 == newest.trajectory ? FindNearest(graph, joins.nearby_most_m) : last;
    const KeyframeId middle = graph.FindByPath(nearest.trajectory, graph.path_m(nearest) - joins.before_m);
    const Submap submap = MakeSubmap(graph, middle, *graph.newest(), constants_.submaps);
    const PlaceReach reach = FindReach(graph, last, between_s, joins);
    const PlaceWindow window{Inverse(graph.pose(middle)) * graph.pose(newest),
                             std::min(reach.reach_m, joins.nearby_most_m),
                             std::min(reach.reach_rad, joins.nearby_most_rad)};
    const HitPyramid pyramid(CollectHits(graph, submap, window.centre, window.reach_m + joins.nearby_point_m),
                             constants_.submaps.cell_m,
                             CollectRays(graph, submap, joins.nearby_point_m, joins.shorter_m));
    best.Add(middle,
             FindPlace(pyramid, points_m, window,
                       {joins.nearby_point_m, best.LeastScore(joins.nearby_score), constants_.submaps.rival_share,
                        joins.nearby_evaluations, match_.map_search.other_place}));
  }
  auto found = best.Unrivalled();
  if (found) {
    const double away_m = Distance(graph.pose(graph.LastOf(newest.trajectory - 1)), graph.pose({newest.trajectory, 0}));
    const double break_s = ComputeBreak(graph, newest.trajectory - 1);
    if (break_s < joins.short_break_s && away_m < joins.nearby_most_m) found->by = LoopFinding::By::kSoon;
  }
  return found;
}

/// Of submaps that cover all components but that of the newest keyframe.
std::vector<KeyframeId> JoinSearch::FindMiddles(const KeyframeGraph& graph) const {
  std::vector<KeyframeId> middles;
  for (int trajectory = 0; trajectory < graph.num_trajectories(); ++trajectory) {
    if (graph.HangTogether({trajectory, 0}, *graph.newest())) continue;
    const double length_m = graph.path_m(graph.LastOf(trajectory));
    if (length_m < constants_.joins.least_length_m) continue;
    const int num_submaps = static_cast<int>(length_m / constants_.submaps.reach_m) + 1;
    for (int i = 0; i < num_submaps; ++i) {
      middles.push_back(graph.FindByPath(trajectory, (i + 0.5) * length_m / num_submaps));
    }
  }
  return middles;
}

/// Which submaps are searched now, and which only if something is found in those. Of so many that they are not all
/// kept, a part takes its turn every few metres, and those near places that were found before always.
JoinSearch::Turn JoinSearch::TakeTurns(const KeyframeGraph& graph, const std::vector<KeyframeId>& middles,
                                       const std::vector<KeyframeId>& found_before) const {
  const GraphConstants::Joins& joins = constants_.joins;
  const std::size_t num_parts = (middles.size() + joins.most_drawn - 1) / joins.most_drawn;
  const auto turn = static_cast<std::size_t>(graph.path_m(*graph.newest()) / joins.every_m) % num_parts;
  const auto WasFoundNear = [&](KeyframeId middle) {
    return std::ranges::any_of(found_before, [&](KeyframeId found) {
      return found.trajectory == middle.trajectory &&
             std::abs(graph.path_m(found) - graph.path_m(middle)) < joins.turn_near_m;
    });
  };
  Turn found;
  for (std::size_t i = 0; i < middles.size(); ++i) {
    const bool is_now = i * num_parts / middles.size() == turn || WasFoundNear(middles[i]);
    (is_now ? found.now : found.later).push_back(middles[i]);
  }
  return found;
}

/// Drawn before, or now. Of a trajectory that has ended nothing changes any more.
const JoinSearch::DrawnSubmap& JoinSearch::Draw(const KeyframeGraph& graph, KeyframeId middle) {
  const GraphConstants::Joins& joins = constants_.joins;
  const auto found = drawn_.find(middle);
  if (found != drawn_.end()) return found->second;
  if (drawn_order_.size() >= joins.most_drawn) {
    drawn_.erase(drawn_order_.front());
    drawn_order_.pop_front();
  }
  drawn_order_.push_back(middle);
  const Submap submap = MakeSubmap(graph, middle, *graph.newest(), constants_.submaps);
  const Eigen::Matrix2Xd hits_m = CollectHits(graph, submap, {}, joins.reach_m + constants_.submaps.farthest_point_m);
  DrawnSubmap drawn{HitPyramid(hits_m, joins.cell_m, CollectRays(graph, submap, joins.seen_m, joins.shorter_m)),
                    ComputeLineSpectrum(ThinOut(hits_m, constants_.submaps.square_m), match_.line_spectrum)};
  return drawn_.emplace(middle, std::move(drawn)).first->second;
}

}  // namespace crsm
