#include "common/graph/loop_search.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "common/graph/draw_scans.hpp"
#include "common/match/fit/optimum.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/match/fit/scored_map.hpp"
#include "common/match/judge/census.hpp"
#include "common/match/search/place_search.hpp"
#include "common/scan/hits.hpp"

namespace crsm {
namespace {

/// How far poses may have drifted apart.
PlaceReach ComputeDrift(const GraphConstants::DriftModel& model, double way_m, double most_m) {
  return {std::min(model.least_m + model.m_per_m * way_m, most_m),
          std::min(model.least_rad + model.rad_per_m * way_m, model.most_rad)};
}

struct Candidate {
  KeyframeId middle;  ///< of a submap
  PlaceReach drift;
};

/// Where the newest keyframe may be.
struct Candidates {
  std::vector<Candidate> unknown;   ///< for which the graph does not vouch
  std::optional<KeyframeId> known;  ///< the nearest old keyframe for which it does
};

/// The ways along the graph from a keyframe to those near it, which are asked for in the order of their names.
class Ways {
 public:
  Ways(const KeyframeGraph& graph, KeyframeId from, double reach_m) : way_m_(graph.FindWithin(from, reach_m)) {}

  /// Infinite beyond the reach.
  double To(KeyframeId id) {
    while (next_ < way_m_.size() && way_m_[next_].first < id) ++next_;
    return next_ < way_m_.size() && way_m_[next_].first == id ? way_m_[next_].second : HUGE_VAL;
  }

 private:
  std::vector<std::pair<KeyframeId, double>> way_m_;
  std::size_t next_ = 0;
};

/// far: also beyond drift.most_m, where the way along the graph is so long.
Candidates FindCandidates(const KeyframeGraph& graph, double local_map_m, const GraphConstants::DriftModel& drift,
                          bool far, const GraphConstants& constants) {
  const GraphConstants::Loops& loops = constants.loops;
  const double slot_m = constants.submaps.reach_m;
  const KeyframeId newest = *graph.newest();
  Candidates found;
  std::optional<Ways> ways;  // not looked for before there is something near
  std::optional<Ways> all_ways;
  double nearest_m = loops.known_m;
  std::pair last_slot{-1, -1};  // trajectory, and which part of it
  for (std::optional<KeyframeId> i = KeyframeId{}; IsLongAgo(graph, *i, constants.submaps.long_ago_m);) {
    const double by_path_m = graph.ComputeDriven(*i, newest);
    const double away_m = Distance(graph.pose(*i), graph.pose(newest));
    const double most_m = far ? loops.farthest_m : drift.most_m;
    const double beyond_m = away_m - ComputeDrift(drift, by_path_m, most_m).reach_m - loops.passing_m;
    if (beyond_m > 0.0) {  // and so are those of the next metres
      const double near_m = graph.path_m(*i) + loops.surely_far * beyond_m;
      i = std::max(*graph.After(*i), graph.FindByPath(i->trajectory, near_m));
      continue;
    }
    const KeyframeId at = *i;
    i = graph.After(at);
    if (!graph.HangTogether(at, newest)) continue;
    if (!ways) ways.emplace(graph, newest, local_map_m);
    // A way through the graph that is much longer than the crow flies is not agreement: the chain may be bent.
    const double way_m = std::min(ways->To(at), by_path_m);
    if (way_m <= local_map_m && way_m <= loops.agreeing_m + loops.agreeing_times * away_m) {
      if (away_m < nearest_m) {
        nearest_m = away_m;
        found.known = at;
      }
      continue;
    }
    PlaceReach there = ComputeDrift(drift, way_m, drift.most_m);
    if (far && away_m > there.reach_m + loops.passing_m) {
      if (!all_ways) all_ways.emplace(graph, newest, HUGE_VAL);
      there = ComputeDrift(drift, all_ways->To(at), loops.farthest_m);
    }
    if (away_m > there.reach_m + loops.passing_m) continue;
    const std::pair slot{at.trajectory, static_cast<int>(graph.path_m(at) / slot_m)};
    if (slot != last_slot) {
      found.unknown.push_back({graph.FindByPath(at.trajectory, (slot.second + 0.5) * slot_m), there});
    } else if (found.unknown.back().drift.reach_m < there.reach_m) {
      found.unknown.back().drift = there;
    }
    last_slot = slot;
  }
  return found;
}

/// Searches of the newest keyframe.
class PlaceFinder {
 public:
  PlaceFinder(const KeyframeGraph& graph, const LoopSearchConstants& constants)
      : graph_(graph),
        constants_(constants),
        points_m_(CollectRecentPoints(graph, *graph.newest(), constants.graph.submaps.farthest_point_m,
                                      constants.graph.submaps)) {}

  bool HasEnough() const { return points_m_.cols() >= constants_.graph.submaps.fewest_points; }

  /// least_score: what is worse is of no interest.
  Place Find(const HitPyramid& pyramid, KeyframeId middle, const PlaceReach& drift, double least_score,
             int most_evaluations) const {
    return FindPlace(pyramid, points_m_, {GuessedIn(middle), drift.reach_m, drift.reach_rad},
                     {constants_.graph.submaps.farthest_point_m, least_score, constants_.graph.submaps.rival_share,
                      most_evaluations, constants_.match.map_search.other_place});
  }

  /// Of what the points may come to lie on in a window of that reach.
  HitPyramid MakePyramid(KeyframeId middle, double reach_m) const {
    const GraphConstants::Submaps& submaps = constants_.graph.submaps;
    return HitPyramid(CollectHits(graph_, MakeSubmap(graph_, middle, *graph_.newest(), submaps), GuessedIn(middle),
                                  reach_m + submaps.farthest_point_m),
                      submaps.cell_m);
  }

  /// Where the matches say that the robot is: if it fits there, whether nowhere nearby as well; else further away.
  Place Check(KeyframeId middle) const {
    const GraphConstants::Check& check = constants_.graph.check;
    const GraphConstants::Loops& loops = constants_.graph.loops;
    const HitPyramid pyramid = MakePyramid(middle, check.far_m);
    const Place here = Find(pyramid, middle, {check.near_m, check.near_rad}, loops.least_score, loops.most_evaluations);
    return here.score >= check.fine_score
               ? Find(pyramid, middle, {check.nearby_m, check.nearby_rad}, loops.least_score, check.nearby_evaluations)
               : Find(pyramid, middle, {check.far_m, check.far_rad}, loops.least_score, loops.most_evaluations);
  }

 private:
  Pose2 GuessedIn(KeyframeId middle) const { return Inverse(graph_.pose(middle)) * graph_.pose(*graph_.newest()); }

  const KeyframeGraph& graph_;
  const LoopSearchConstants& constants_;
  Eigen::Matrix2Xd points_m_;
};

/// Where the robot is of the places for which the graph does not vouch. known_score: of one that is known.
std::optional<LoopFinding> SearchUnknown(const KeyframeGraph& graph, const Candidates& candidates, double known_score,
                                         const LoopSearchConstants& constants) {
  if (candidates.unknown.empty()) return std::nullopt;
  const PlaceFinder finder(graph, constants);
  if (!finder.HasEnough()) return std::nullopt;
  BestFinding best(graph, constants.graph.submaps, LoopFinding::By::kDrift);
  for (const auto& [middle, drift] : candidates.unknown) {
    const double least_score =
        best.LeastScore(std::max(constants.graph.loops.least_score, constants.graph.submaps.rival_share * known_score));
    best.Add(middle, finder.Find(finder.MakePyramid(middle, drift.reach_m), middle, drift, least_score,
                                 constants.graph.loops.most_evaluations));
  }
  return best.Unrivalled();
}

/// Whether the robot is where the matches say.
std::optional<LoopFinding> CheckKnown(const KeyframeGraph& graph, KeyframeId middle,
                                      const LoopSearchConstants& constants) {
  const PlaceFinder finder(graph, constants);
  if (!finder.HasEnough()) return std::nullopt;
  BestFinding best(graph, constants.graph.submaps, LoopFinding::By::kCheck);
  best.Add(middle, finder.Check(middle));
  return best.Unrivalled();
}

}  // namespace

std::optional<LoopFinding> SearchLoop(const KeyframeGraph& graph, double local_map_m, bool thoroughly,
                                      const LoopSearchConstants& constants) {
  const auto& [usual, largest] = std::tie(constants.graph.loops.usual, constants.graph.loops.largest);
  double known_score = 0.0;
  if (!thoroughly) {
    const auto likely =
        SearchUnknown(graph, FindCandidates(graph, local_map_m, usual, false, constants.graph), 0.0, constants);
    if (!likely) return std::nullopt;
    known_score = likely->score;
  }
  const Candidates candidates = FindCandidates(graph, local_map_m, largest, thoroughly, constants.graph);
  if (thoroughly && candidates.unknown.empty() && candidates.known) {
    return CheckKnown(graph, *candidates.known, constants);
  }
  return SearchUnknown(graph, candidates, known_score, constants);
}

std::optional<Loop> MakeLoop(const KeyframeGraph& graph, const LoopFinding& finding, const DrawingRules& drawing,
                             const LoopSearchConstants& constants) {
  const Submap submap = MakeSubmap(graph, finding.older, finding.newer, constants.graph.submaps);
  return MakeLoop({graph, submap, graph}, finding, drawing, constants);
}

std::optional<Loop> MakeLoop(const FoundIn& place, const LoopFinding& finding, const DrawingRules& drawing,
                             const LoopSearchConstants& constants) {
  const GraphConstants::Submaps& submaps = constants.graph.submaps;
  const auto& [older, submap, newer] = place;
  std::vector<PlacedScan> scans;
  for (KeyframeId at = submap.first; at <= submap.last; ++at.number) {
    scans.push_back({older.keyframe(at).rays, older.Motion(finding.older, at)});
  }
  const ScoredMap map(DrawScans(drawing, scans));
  const RaysInCells rays =
      ToCells(CollectRecentPoints(newer, finding.newer, submaps.farthest_point_m, submaps), map.geometry());
  const Pose2 pose = FindOptimum(
      finding.T_older_newer, submaps.cell_m, submaps.optimum_rad,
      [&](const Pose2& at) { return map.Differentiate(rays, at); }, constants.match.optimum);

  const Eigen::Matrix2Xd newest_hits_m = ComputeHits(newer.keyframe(finding.newer).rays.Unpack());
  const bool told_by_rays = finding.by == LoopFinding::By::kSoon || finding.by == LoopFinding::By::kNearby;
  // The newest scan may see little of the submap.
  if (!told_by_rays &&
      CountRays(map.cells(), newest_hits_m, pose, constants.match.census).fits < submaps.least_agreement) {
    return std::nullopt;
  }
  const auto nearest = std::min_element(scans.begin(), scans.end(), [&](const PlacedScan& a, const PlacedScan& b) {
    return Distance(a.T_map_laser, pose) < Distance(b.T_map_laser, pose);
  });
  const int number = submap.first.number + static_cast<int>(nearest - scans.begin());
  return Loop{{submap.first.trajectory, number}, finding.newer, Inverse(nearest->T_map_laser) * pose};
}

}  // namespace crsm
