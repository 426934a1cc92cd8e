#include "common/fleet/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/fleet/fleet_search.hpp"
#include "common/graph/loop_search.hpp"
#include "common/graph/submap_loop_closer.hpp"

namespace crsm {
Fleet::Fleet(const LoopParameters& loops, const DrawingRules& drawing, const FleetConstants& constants)
    : loops_(loops),
      drawing_(drawing),
      constants_(constants),
      graph_(constants),
      search_(std::make_unique<FleetSearch>(constants)) {}

Fleet::~Fleet() = default;

int Fleet::BeginMap() {
  members_.emplace_back().closer =
      std::make_unique<SubmapLoopCloser>(loops_, drawing_, constants_.graph, constants_.match);
  return graph_.AddMap(members_.back().closer->graph());
}

bool Fleet::Fits(int map, const Keyframe& keyframe, const std::optional<LoopFinding>& own) const {
  const KeyframeGraph& graph = graph_.map(map);
  const auto IsThere = [&](const std::optional<KeyframeId>& id) { return !id || graph.Has(*id); };
  if (graph.size() == 0 && !keyframe.begins) return false;
  return (!keyframe.constraint || graph.Has(keyframe.constraint->keyframe)) && IsThere(keyframe.as_of) &&
         (!own || graph.Has(own->older));
}

bool Fleet::Fits(int map, const FleetFinding& finding) const {
  return finding.older.map != map && finding.older.map < num_maps() &&
         graph_.map(finding.older.map).Has(finding.older.id);
}

std::optional<FleetFinding> Fleet::Add(int map, Keyframe keyframe, const std::optional<LoopFinding>& own,
                                       const std::optional<EarlierFleetSearch>& earlier) {
  const auto update = member(map).closer->Add(std::move(keyframe), EarlierSearch{own});
  graph_.AddNewest(map);
  keyframes_.push_back(graph_.newest(map));
  if (update && update->ChangesGraph()) graph_.TakeOver(map, *update);
  if (IsContradicted(map)) {
    graph_.DropLoopsOf(graph_.newest(map));
    member(map).findings.clear();
    return std::nullopt;
  }
  const auto finding = Search(map, earlier);
  if (finding) Confirm(*finding);
  return finding;
}

/// Where the newest keyframe of a map is on others: in pieces that it is no part of, while there are some; then where
/// it is by the graph.
std::optional<FleetFinding> Fleet::Search(int map, const std::optional<EarlierFleetSearch>& earlier) {
  Member& of = member(map);
  const FleetKeyframeId newest = graph_.newest(map);
  const double here_m = graph_.map(map).path_m(newest.id);
  if (newest.id.number == 0) of.next_elsewhere_m = of.next_near_m = of.known_m = 0.0;
  if (num_maps() < 2) return std::nullopt;
  const bool elsewhere = here_m >= of.next_elsewhere_m;
  const bool near = here_m >= of.next_near_m;
  if (!elsewhere && !near) return std::nullopt;
  if (elsewhere) of.next_elsewhere_m = here_m + constants_.graph.joins.every_m;
  if (near) of.next_near_m = here_m + constants_.near_every_m;
  if (earlier) return earlier->finding;
  ++num_searched_;
  if (elsewhere) {
    std::vector<FleetKeyframeId> found_before;
    for (const Remembered& one : of.findings) {
      if (!graph_.HangTogether(one.finding.older, newest)) found_before.push_back(one.finding.older);
    }
    if (auto found = search_->SearchElsewhere(graph_, map, found_before)) return found;
  }
  return near ? search_->SearchNear(graph_, map, here_m - of.known_m) : std::nullopt;
}

/// Adds the loops of a finding and of an earlier one that agrees with it.
void Fleet::Confirm(const FleetFinding& finding) {
  Member& of = member(finding.newer.map);
  const KeyframeGraph& graph = graph_.map(finding.newer.map);
  const double here_m = graph.path_m(finding.newer.id);
  std::erase_if(of.findings, [&](const Remembered& one) {
    const double remembered_m = graph_.HangTogether(one.finding.older, one.finding.newer)
                                    ? constants_.graph.loops.remembered_m
                                    : constants_.graph.joins.remembered_m;
    return one.finding.newer.id.trajectory != finding.newer.id.trajectory ||
           here_m - graph.path_m(one.finding.newer.id) > remembered_m;
  });
  of.findings.push_back({finding});
  for (std::size_t i = 0; i + 1 < of.findings.size(); ++i) {
    if (!Agree(of.findings[i].finding, finding)) continue;
    of.known_m = here_m;
    for (Remembered* one : {&of.findings[i], &of.findings.back()}) {
      if (std::exchange(one->is_loop, true) || SaysNothingNew(one->finding)) continue;
      const auto loop = MakeLoop(one->finding);
      if (!loop) continue;
      if (!graph_.HangTogether(loop->older, loop->newer)) {
        WatchFrom(graph_.newest(loop->older.map));
        WatchFrom(graph_.newest(loop->newer.map));
      }
      graph_.AddLoop(*loop);
    }
    return;
  }
}

/// Whether they say the same of how two maps lie to each other.
bool Fleet::Agree(const FleetFinding& earlier, const FleetFinding& later) const {
  if (!graph_.HangTogether(earlier.older, later.older) || !AreApart(earlier, later)) return false;
  const Pose2 expected = Inverse(graph_.pose(later.older)) * graph_.pose(earlier.older) * earlier.T_older_newer *
                         graph_.map(later.newer.map).Motion(earlier.newer.id, later.newer.id);
  return AreNear(expected, later.T_older_newer, constants_.graph.loops.agree_m, constants_.graph.loops.agree_rad);
}

/// Whether they are so far apart along the path that they saw different things.
bool Fleet::AreApart(const FleetFinding& earlier, const FleetFinding& later) const {
  const KeyframeGraph& graph = graph_.map(later.newer.map);
  const double apart_m = graph.path_m(later.newer.id) - graph.path_m(earlier.newer.id);
  if (graph_.HangTogether(later.older, later.newer)) return apart_m >= constants_.graph.loops.least_apart_m;
  return apart_m >= constants_.graph.joins.least_apart_m &&
         Length(graph.Motion(earlier.newer.id, later.newer.id)) >= constants_.graph.joins.least_away_m;
}

/// Whether it says what the graph says, and a loop nearby has said so, too.
bool Fleet::SaysNothingNew(const FleetFinding& finding) const {
  if (!graph_.HangTogether(finding.older, finding.newer)) return false;
  const Pose2 expected = Inverse(graph_.pose(finding.older)) * graph_.pose(finding.newer);
  const double cell_m = constants_.graph.submaps.cell_m;
  if (!AreNear(expected, finding.T_older_newer, constants_.agrees_m + cell_m, constants_.agrees_rad)) return false;
  const KeyframeGraph& graph = graph_.map(finding.newer.map);
  return std::ranges::any_of(graph_.loops(), [&](const FleetLoop& loop) {
    return loop.newer.map == finding.newer.map && loop.older.map == finding.older.map &&
           loop.newer.id.trajectory == finding.newer.id.trajectory &&
           std::abs(graph.path_m(loop.newer.id) - graph.path_m(finding.newer.id)) < constants_.same_loop_m;
  });
}

/// Its pose refined on a map of what was seen there; nothing if the rays of the newer keyframe would run through walls.
std::optional<FleetLoop> Fleet::MakeLoop(const FleetFinding& finding) const {
  const KeyframeGraph& older = graph_.map(finding.older.map);
  const Submap submap = MakeSubmapAround(older, finding.older.id, constants_.graph.submaps);
  const LoopFinding found{finding.older.id, finding.newer.id, finding.T_older_newer, finding.score,
                          finding.anywhere ? LoopFinding::By::kAnywhere : LoopFinding::By::kDrift};
  const auto loop = crsm::MakeLoop({older, submap, graph_.map(finding.newer.map)}, found, drawing_,
                                   {constants_.graph, constants_.match});
  if (!loop) return std::nullopt;
  return FleetLoop{{finding.older.map, loop->older}, {finding.newer.map, loop->newer}, loop->T_older_newer};
}

void Fleet::WatchFrom(const FleetKeyframeId& at) {
  const double here_m = graph_.map(at.map).path_m(at.id);
  member(at.map).watch = {at.id.trajectory, here_m, here_m + constants_.graph.joins.every_m};
}

/// Whether what was seen contradicts a join, in two places that share nothing of what was seen.
bool Fleet::IsContradicted(int map) {
  const GraphConstants::Joins& joins = constants_.graph.joins;
  Watch& watch = member(map).watch;
  const KeyframeId newest = graph_.newest(map).id;
  const double here_m = graph_.map(map).path_m(newest);
  if (newest.trajectory != watch.trajectory || here_m > watch.joined_m + joins.checked_m) watch.trajectory = -1;
  if (watch.trajectory < 0 || here_m < watch.next_m) return false;
  watch.next_m = here_m + joins.every_m;
  const auto share = search_->ComputeContradiction(graph_, map);
  if (!share || *share < joins.contradicted_share) return false;
  if (!watch.contradicted_m) watch.contradicted_m = here_m;
  if (here_m - *watch.contradicted_m < joins.least_apart_m) return false;
  watch.trajectory = -1;
  return true;
}

}  // namespace crsm
