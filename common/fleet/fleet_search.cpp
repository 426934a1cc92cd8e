#include "common/fleet/fleet_search.hpp"

#include <algorithm>
#include <cmath>

#include "common/graph/submap.hpp"

namespace crsm {
namespace {

/// The best place of all that was searched, and how well the best other place fits.
class BestPlace {
 public:
  BestPlace(const FleetGraph& fleet, const FleetKeyframeId& newer, const GraphConstants::Submaps& constants)
      : fleet_(fleet), newer_(newer), constants_(constants) {}

  double LeastScore(double least) const { return std::max(least, best_ ? constants_.rival_share * best_->score : 0.0); }

  void Add(const FleetKeyframeId& middle, const Place& place) {
    if (place.score == 0.0) return;
    rival_ = std::max(rival_, place.rival);
    const FleetFinding finding{middle, newer_, place.pose, place.score, true};
    if (best_ && AreApart(finding, *best_)) rival_ = std::max(rival_, std::min(place.score, best_->score));
    if (!best_ || place.score > best_->score) best_ = finding;
  }

  std::optional<FleetFinding> Unrivalled() const {
    return best_ && rival_ <= constants_.rival_share * best_->score ? best_ : std::nullopt;
  }

 private:
  /// Whether they are two places. Of those of two pieces nobody knows.
  bool AreApart(const FleetFinding& a, const FleetFinding& b) const {
    if (!fleet_.HangTogether(a.older, b.older)) return false;
    const Pose2 apart = Inverse(fleet_.pose(a.older) * a.T_older_newer) * (fleet_.pose(b.older) * b.T_older_newer);
    return Length(apart) > constants_.same_place_m;
  }

  const FleetGraph& fleet_;
  FleetKeyframeId newer_;
  const GraphConstants::Submaps& constants_;
  std::optional<FleetFinding> best_;
  double rival_ = 0.0;
};

double LengthOf(const KeyframeGraph& map, int trajectory) { return map.path_m(map.LastOf(trajectory)); }

}  // namespace

std::optional<FleetFinding> FleetSearch::SearchElsewhere(const FleetGraph& fleet, int map,
                                                         const std::vector<FleetKeyframeId>& found_before) {
  const GraphConstants::Joins& joins = constants_.graph.joins;
  const GraphConstants::Submaps& submaps = constants_.graph.submaps;
  const std::vector<PartKey> parts = ListParts(fleet, map);
  if (parts.empty()) return std::nullopt;
  const FleetKeyframeId newest = fleet.newest(map);
  const Eigen::Matrix2Xd points_m = CollectRecentPoints(fleet.map(map), newest.id, submaps.farthest_point_m, submaps);
  if (points_m.cols() < submaps.fewest_points) return std::nullopt;
  const LineSpectrum spectrum = ComputeLineSpectrum(points_m, constants_.match.line_spectrum);
  BestPlace best(fleet, newest, submaps);
  const auto SearchIn = [&](const PartKey& key) {
    const DrawnPart& part = Draw(fleet, key);
    const Turns turns = FindBestTurns(part.spectrum, spectrum, joins.num_turns);
    const Place place = FindPlace(part.pyramid, points_m, {{}, joins.reach_m, kPi, turns},
                                  {submaps.farthest_point_m, best.LeastScore(joins.least_score), submaps.rival_share,
                                   joins.most_evaluations, constants_.match.map_search.other_place});
    if (place.evaluations <= joins.most_evaluations) best.Add({std::get<0>(key), part.middle}, place);
  };
  const auto [now, later] = TakeTurns(fleet, map, parts, found_before);
  std::ranges::for_each(now, SearchIn);
  if (!best.Unrivalled()) return std::nullopt;
  std::ranges::for_each(later, SearchIn);  // is there another one like it?
  return best.Unrivalled();
}

std::optional<FleetFinding> FleetSearch::SearchNear(const FleetGraph& fleet, int map, double way_m) const {
  const GraphConstants::Loops& loops = constants_.graph.loops;
  const GraphConstants::Submaps& submaps = constants_.graph.submaps;
  const GraphConstants::DriftModel& drift = loops.largest;
  const double reach_m = std::min(drift.least_m + drift.m_per_m * way_m, drift.most_m);
  const double reach_rad = std::min(drift.least_rad + drift.rad_per_m * way_m, drift.most_rad);
  const auto nearest = FindNearest(fleet, map, loops.passing_m + reach_m);
  if (!nearest) return std::nullopt;
  const FleetKeyframeId newest = fleet.newest(map);
  const Eigen::Matrix2Xd points_m = CollectRecentPoints(fleet.map(map), newest.id, submaps.farthest_point_m, submaps);
  if (points_m.cols() < submaps.fewest_points) return std::nullopt;
  const KeyframeGraph& other = fleet.map(nearest->map);
  const Submap submap = MakeSubmapAround(other, nearest->id, submaps);
  const Pose2 expected = Inverse(fleet.pose(*nearest)) * fleet.pose(newest);
  const HitPyramid pyramid(CollectHits(other, submap, expected, reach_m + submaps.farthest_point_m), submaps.cell_m);
  const Place place = FindPlace(pyramid, points_m, {expected, reach_m, reach_rad},
                                {submaps.farthest_point_m, loops.least_score, submaps.rival_share,
                                 loops.most_evaluations, constants_.match.map_search.other_place});
  if (place.score == 0.0 || place.evaluations > loops.most_evaluations) return std::nullopt;
  if (place.rival > submaps.rival_share * place.score) return std::nullopt;
  return FleetFinding{*nearest, newest, place.pose, place.score, false};
}

std::optional<double> FleetSearch::ComputeContradiction(const FleetGraph& fleet, int map) const {
  const GraphConstants::Joins& joins = constants_.graph.joins;
  const GraphConstants::Submaps& submaps = constants_.graph.submaps;
  const auto nearest = FindNearest(fleet, map, joins.checked_within_m);
  if (!nearest) return std::nullopt;
  const FleetKeyframeId newest = fleet.newest(map);
  const Eigen::Matrix2Xd points_m = CollectRecentPoints(fleet.map(map), newest.id, submaps.farthest_point_m, submaps);
  const KeyframeGraph& other = fleet.map(nearest->map);
  const Pose2 expected = Inverse(fleet.pose(*nearest)) * fleet.pose(newest);
  const Submap submap = MakeSubmapAround(other, nearest->id, submaps);
  const HitPyramid pyramid(CollectHits(other, submap, expected, submaps.farthest_point_m + joins.cell_m), joins.cell_m,
                           CollectRays(other, submap, joins.seen_m, joins.shorter_m));
  const auto [on_hits, on_free] = pyramid.Lay(points_m, expected);
  if (on_hits + on_free < submaps.fewest_points) return std::nullopt;
  return static_cast<double>(on_free) / (on_hits + on_free);
}

/// Of other maps the keyframe that is nearest to the newest one of this map, on the same piece.
std::optional<FleetKeyframeId> FleetSearch::FindNearest(const FleetGraph& fleet, int map, double within_m) const {
  const FleetKeyframeId newest = fleet.newest(map);
  const Pose2& here = fleet.pose(newest);
  std::optional<FleetKeyframeId> nearest;
  double nearest_m = within_m;
  for (const auto& [other, trajectory] : fleet.trajectories()) {
    if (other == map || !fleet.HangTogether({other, {trajectory, 0}}, newest)) continue;
    const KeyframeGraph& graph = fleet.map(other);
    for (FleetKeyframeId at{other, {trajectory, 0}}; at.id <= graph.LastOf(trajectory); ++at.id.number) {
      const double away_m = Distance(fleet.pose(at), here);
      if (away_m >= nearest_m) continue;
      nearest_m = away_m;
      nearest = at;
    }
  }
  return nearest;
}

/// Parts that cover all trajectories of other maps that are not one piece with this one.
std::vector<FleetSearch::PartKey> FleetSearch::ListParts(const FleetGraph& fleet, int map) const {
  std::vector<PartKey> parts;
  for (const auto& [other, trajectory] : fleet.trajectories()) {
    if (other == map || fleet.HangTogether({other, {trajectory, 0}}, fleet.newest(map))) continue;
    const double length_m = LengthOf(fleet.map(other), trajectory);
    if (length_m < constants_.graph.joins.least_length_m) continue;
    const int num_parts = static_cast<int>(length_m / constants_.graph.submaps.reach_m) + 1;
    for (int i = 0; i < num_parts; ++i) parts.emplace_back(other, trajectory, i);
  }
  return parts;
}

KeyframeId FleetSearch::MiddleOf(const FleetGraph& fleet, const PartKey& key) const {
  const auto& [map, trajectory, part] = key;
  const double reach_m = constants_.graph.submaps.reach_m;
  const double middle_m = std::min((part + 0.5) * reach_m, LengthOf(fleet.map(map), trajectory));
  return fleet.map(map).FindByPath(trajectory, middle_m);
}

/// Which parts are searched now, and which only if something is found in those. Of so many that they are not all kept,
/// some take their turn every few metres, and those near places that were found before always.
FleetSearch::Turn FleetSearch::TakeTurns(const FleetGraph& fleet, int map, const std::vector<PartKey>& parts,
                                         const std::vector<FleetKeyframeId>& found_before) const {
  const GraphConstants::Joins& joins = constants_.graph.joins;
  const std::size_t num_turns = (parts.size() + joins.most_drawn - 1) / joins.most_drawn;
  const double here_m = fleet.map(map).path_m(fleet.newest(map).id);
  const auto turn = static_cast<std::size_t>(here_m / joins.every_m) % num_turns;
  const auto WasFoundNear = [&](const PartKey& key) {
    const FleetKeyframeId middle{std::get<0>(key), MiddleOf(fleet, key)};
    const KeyframeGraph& graph = fleet.map(middle.map);
    return std::ranges::any_of(found_before, [&](const FleetKeyframeId& found) {
      return found.map == middle.map && found.id.trajectory == middle.id.trajectory &&
             std::abs(graph.path_m(found.id) - graph.path_m(middle.id)) < joins.turn_near_m;
    });
  };
  Turn found;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool is_now = i * num_turns / parts.size() == turn || (num_turns > 1 && WasFoundNear(parts[i]));
    (is_now ? found.now : found.later).push_back(parts[i]);
  }
  return found;
}

/// Drawn before, or now. What is at the end of a trajectory grows with it.
const FleetSearch::DrawnPart& FleetSearch::Draw(const FleetGraph& fleet, const PartKey& key) {
  const GraphConstants::Joins& joins = constants_.graph.joins;
  const GraphConstants::Submaps& submaps = constants_.graph.submaps;
  const auto& [map, trajectory, part] = key;
  const KeyframeGraph& graph = fleet.map(map);
  const double length_m = LengthOf(graph, trajectory);
  const auto found = drawn_.find(key);
  if (found != drawn_.end()) {
    const bool is_whole = found->second.length_m >= (part + 0.5) * submaps.reach_m + submaps.reach_m;
    if (is_whole || length_m - found->second.length_m < joins.every_m) return found->second;
    drawn_.erase(found);
    std::erase(drawn_order_, key);
  }
  if (drawn_order_.size() >= joins.most_drawn) {
    drawn_.erase(drawn_order_.front());
    drawn_order_.pop_front();
  }
  drawn_order_.push_back(key);
  const KeyframeId middle = MiddleOf(fleet, key);
  const Submap submap = MakeSubmapAround(graph, middle, submaps);
  const Eigen::Matrix2Xd hits_m = CollectHits(graph, submap, {}, joins.reach_m + submaps.farthest_point_m);
  DrawnPart drawn{middle, length_m,
                  HitPyramid(hits_m, joins.cell_m, CollectRays(graph, submap, joins.seen_m, joins.shorter_m)),
                  ComputeLineSpectrum(ThinOut(hits_m, submaps.square_m), constants_.match.line_spectrum)};
  return drawn_.emplace(key, std::move(drawn)).first->second;
}

}  // namespace crsm
