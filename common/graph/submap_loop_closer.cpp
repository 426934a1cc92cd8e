#include "common/graph/submap_loop_closer.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "common/graph/loop_search.hpp"

namespace crsm {
namespace {

/// What has moved: of each trajectory the keyframes from the first to the last one that has.
std::vector<PoseStretch> FindMoved(const KeyframePoses& before, const KeyframePoses& after) {
  std::vector<PoseStretch> moved;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const auto first = std::ranges::mismatch(before[i], after[i]).in2;
    if (first == after[i].end()) continue;
    const auto end = std::mismatch(before[i].rbegin(), before[i].rend(), after[i].rbegin()).second.base();
    moved.push_back({{static_cast<int>(i), static_cast<int>(first - after[i].begin())}, {first, end}});
  }
  return moved;
}

/// What an earlier search has found elsewhere than in the newest keyframe's component.
std::optional<LoopFinding> FoundElsewhere(const EarlierSearch& earlier) {
  const auto& finding = earlier.finding;
  const bool within = finding && (finding->by == LoopFinding::By::kDrift || finding->by == LoopFinding::By::kCheck);
  return within ? std::nullopt : finding;
}

}  // namespace

std::optional<GraphUpdate> SubmapLoopCloser::Add(Keyframe keyframe, const std::optional<EarlierSearch>& earlier) {
  keyframe.constraint_wrong = keyframe.as_of < constraints_wrong_before_;
  GraphUpdate update;
  update.keyframe = graph_.Add(std::move(keyframe));
  if (join_check_.IsContradicted(graph_)) {
    TakeApart(update);
    return update;
  }
  const auto finding = update.finding = Search(earlier);
  if (!finding) return std::nullopt;
  update.previous = std::exchange(update_, update.keyframe);
  const bool checked = finding->by == LoopFinding::By::kCheck;
  if (checked && AgreesWithGraph(finding->older, finding->newer, finding->T_older_newer, 1.0)) {
    verified_ = update.keyframe;
    return update;
  }
  if (ContradictsBridges(*finding)) return update;
  const GraphUpdate* known = earlier ? earlier->update.get() : nullptr;
  update.closed = Confirm(*finding, known);
  if (update.closed.empty()) return update;
  if (checked) {
    update.constraints_wrong_from = graph_.After(verified_);
    graph_.DropConstraints(*update.constraints_wrong_from);
    constraints_wrong_before_ = update.keyframe;
  }
  verified_ = update.keyframe;
  Solve(update, known);
  return update;
}

/// Whether loops say what the graph says already. They wait until others tell more, or until so many keyframes have
/// come since it was solved that solving costs the same for each of them, however large the graph is.
bool SubmapLoopCloser::CanWait(const std::vector<Loop>& loops) const {
  const auto Agrees = [&](const Loop& loop) {
    return graph_.HangTogether(loop.older, loop.newer) &&
           AgreesWithGraph(loop.older, loop.newer, loop.T_older_newer, constants_.loops.waits);
  };
  const int num_new = graph_.size() - solved_size_;
  return graph_.size() >= constants_.loops.waits_from && num_new < constants_.loops.waits_growth * graph_.size() &&
         std::ranges::all_of(loops, Agrees);
}

/// Adds the loops that an update has closed, and moves the keyframes. earlier: that update, as it was found then.
void SubmapLoopCloser::Solve(GraphUpdate& update, const GraphUpdate* earlier) {
  const KeyframePoses before = earlier ? KeyframePoses() : graph_.poses();
  if (earlier) update.closed = earlier->closed;  // and what was rejected before
  const bool can_wait = CanWait(update.closed);
  for (const Loop& loop : update.closed) {
    if (!graph_.HangTogether(loop.older, loop.newer)) join_check_.Watch(graph_);
    graph_.Join(loop);
    graph_.AddLoop(loop);
  }
  if (earlier) {
    update.rejected = earlier->rejected;
    update.moved = earlier->moved;
    for (const Loop& loop : update.rejected) graph_.DropLoop(loop);
    graph_.Move(update);
  } else if (!can_wait) {
    update.rejected = graph_.Optimise();
    if (!update.rejected.empty()) JudgeTogether(update);
    update.moved = FindMoved(before, graph_.poses());
  }
  if (!can_wait) solved_size_ = graph_.size();
  for (const Loop& loop : update.closed) std::erase(contradicted_, loop);
  std::ranges::copy(update.rejected, std::back_inserter(contradicted_));
}

/// One loop against the way between its ends may be wrong. Those that were rejected before, and say the same as one
/// that is rejected now, are asked once more: several know better than a way on which one match has slipped.
void SubmapLoopCloser::JudgeTogether(GraphUpdate& update) {
  std::vector<Loop> others;
  std::ranges::copy_if(contradicted_, std::back_inserter(others), [&](const Loop& loop) {
    return std::ranges::any_of(update.rejected, [&](const Loop& rejected) { return SayTheSame(loop, rejected); });
  });
  if (others.empty()) return;
  for (const Loop& loop : others) graph_.AddLoop(loop);
  for (const Loop& loop : update.rejected) graph_.AddLoop(loop);
  update.rejected = graph_.Optimise();
  for (const Loop& loop : others) {
    if (std::erase(update.rejected, loop) == 0) update.closed.push_back(loop);
  }
}

/// Whether two loops would move what is newer alike.
bool SubmapLoopCloser::SayTheSame(const Loop& loop, const Loop& other) const {
  if (!graph_.HangTogether(loop.newer, other.newer) || !graph_.HangTogether(loop.older, other.older)) return false;
  const auto NewFromOld = [&](const Loop& of) {
    return graph_.pose(of.older) * of.T_older_newer * Inverse(graph_.pose(of.newer));
  };
  const Pose2& at = graph_.pose(other.newer);
  return AreNear(NewFromOld(loop) * at, NewFromOld(other) * at, constants_.loops.agree_m, constants_.loops.agree_rad);
}

/// The newest trajectory hangs together with no other any more. The poses stay as they are.
void SubmapLoopCloser::TakeApart(GraphUpdate& update) {
  update.previous = std::exchange(update_, update.keyframe);
  update.rejected = graph_.FindLoopsAcross(update.keyframe.trajectory);
  for (const Loop& loop : update.rejected) graph_.DropLoop(loop);
  findings_.clear();
}

/// Where the newest keyframe is: in another component first, while there is one; then in its own. What an earlier
/// search came to is not searched again.
std::optional<LoopFinding> SubmapLoopCloser::Search(const std::optional<EarlierSearch>& earlier) {
  const GraphConstants::Loops& loops = constants_.loops;
  const GraphConstants::Joins& joins = constants_.joins;
  const KeyframeId newest = *graph_.newest();
  const double here_m = graph_.path_m(newest);
  if (newest.number == 0) next_elsewhere_m_ = next_search_m_ = next_thorough_m_ = 0.0;
  if (!graph_.is_one_component() && here_m >= next_elsewhere_m_) {
    next_elsewhere_m_ = here_m + (here_m < joins.soon_m ? joins.soon_every_m : joins.every_m);
    if (const auto finding = earlier ? FoundElsewhere(*earlier) : joins_.Search(graph_, PlacesFoundBefore()))
      return finding;
  }
  if (here_m < next_search_m_) return std::nullopt;
  next_search_m_ = here_m + loops.every_m;
  const bool thoroughly = here_m >= next_thorough_m_;
  if (thoroughly) next_thorough_m_ = here_m + loops.thoroughly_every_m;
  if (earlier) return earlier->finding;
  return SearchLoop(graph_, parameters_.local_map_m, thoroughly, {constants_, match_});
}

/// How long the trajectories of other components are.
double SubmapLoopCloser::ComputeWayElsewhere() const {
  double way_m = 0.0;
  for (int i = 0; i < graph_.num_trajectories(); ++i) {
    const KeyframeId last = graph_.LastOf(i);
    if (!graph_.HangTogether(last, *graph_.newest())) way_m += graph_.path_m(last);
  }
  return way_m;
}

/// Where in other components the newest trajectory was found.
std::vector<KeyframeId> SubmapLoopCloser::PlacesFoundBefore() const {
  std::vector<KeyframeId> places;
  for (const Remembered& one : findings_) {
    const bool elsewhere = !graph_.HangTogether(one.finding.older, *graph_.newest());
    if (elsewhere && one.finding.newer.trajectory == graph_.newest()->trajectory) places.push_back(one.finding.older);
  }
  return places;
}

/// Whether a loop would say what the graph says already, but for some of its standard deviations.
bool SubmapLoopCloser::AgreesWithGraph(KeyframeId older, KeyframeId newer, const Pose2& T_older_newer,
                                       double sigmas) const {
  const MotionSigma& sigma = constants_.edges.loop;
  const Pose2 expected = Inverse(graph_.pose(older)) * graph_.pose(newer);
  return AreNear(expected, T_older_newer, sigmas * sigma.x_m, sigmas * sigma.yaw_rad);
}

/// Whether the wheels say that the robot is elsewhere: rooms and corridors are alike, and wheels that were right so far
/// know better.
bool SubmapLoopCloser::ContradictsBridges(const LoopFinding& finding) const {
  const auto bridges = graph_.SumBridges(finding.older, finding.newer);
  if (!bridges || graph_.HangTogether(finding.older, finding.newer)) return false;
  const auto& [joins, loops] = std::tie(constants_.joins, constants_.loops);
  const double way_m = graph_.ComputeDriven(finding.older, finding.newer);
  const Pose2 expected = Inverse(graph_.pose(finding.older)) * graph_.pose(finding.newer);
  return !AreNear(
      expected, finding.T_older_newer,
      joins.bridged_sigmas * bridges->sigma_m + loops.largest.least_m + loops.largest.m_per_m * way_m,
      joins.bridged_sigmas * bridges->sigma_rad + loops.largest.least_rad + loops.largest.rad_per_m * way_m);
}

/// Whether they are of one drift: the robot moved between them as it was matched.
bool SubmapLoopCloser::Agree(const LoopFinding& earlier, const LoopFinding& later) const {
  if (earlier.newer.trajectory != later.newer.trajectory) return false;
  if (!graph_.HangTogether(earlier.older, later.older)) return false;
  if (!AreApart(earlier, later)) return false;
  const Pose2 expected = Inverse(graph_.pose(later.older)) * graph_.pose(earlier.older) * earlier.T_older_newer *
                         graph_.Motion(earlier.newer, later.newer);
  return AreNear(expected, later.T_older_newer, constants_.loops.agree_m, constants_.loops.agree_rad);
}

/// Whether they are so far apart along the path that they saw different things. Two places that are alike look alike
/// for metres: for a join that may be anywhere nothing may count twice.
bool SubmapLoopCloser::AreApart(const LoopFinding& earlier, const LoopFinding& later) const {
  const GraphConstants::Joins& joins = constants_.joins;
  const double apart_m = graph_.path_m(later.newer) - graph_.path_m(earlier.newer);
  if (graph_.HangTogether(later.older, later.newer)) return apart_m >= constants_.loops.least_apart_m;
  if (earlier.by == LoopFinding::By::kSoon && later.by == LoopFinding::By::kSoon)
    return apart_m >= joins.nearby_apart_m;
  const bool clear = std::min(earlier.score, later.score) >= joins.least_score;
  const double least_m =
      clear && ComputeWayElsewhere() < joins.few_m ? joins.least_apart_of_few_m : joins.least_apart_m;
  return apart_m >= least_m && Length(graph_.Motion(earlier.newer, later.newer)) >= joins.least_away_m;
}

/// The loops of a finding and of an earlier one that agrees with it; none without such a one. earlier: what it has
/// brought then.
std::vector<Loop> SubmapLoopCloser::Confirm(const LoopFinding& finding, const GraphUpdate* earlier) {
  const auto Make = [&](const LoopFinding& found) -> std::optional<Loop> {
    if (!earlier) return MakeLoop(graph_, found, drawing_, {constants_, match_});
    const auto loop = std::ranges::find(earlier->closed, found.newer, &Loop::newer);
    return loop == earlier->closed.end() ? std::nullopt : std::optional(*loop);
  };
  const double here_m = graph_.path_m(finding.newer);
  std::erase_if(findings_, [&](const Remembered& one) {
    const auto& [older, newer] = std::tie(one.finding.older, one.finding.newer);
    const double remembered_m =
        graph_.HangTogether(older, newer) ? constants_.loops.remembered_m : constants_.joins.remembered_m;
    return newer.trajectory != finding.newer.trajectory || here_m - graph_.path_m(newer) > remembered_m;
  });
  std::vector<Loop> loops;
  findings_.push_back({finding});
  if (finding.by == LoopFinding::By::kSoon && finding.score >= constants_.joins.sure_score) {
    findings_.back().is_loop = true;
    if (const auto loop = Make(finding)) loops.push_back(*loop);
    return loops;
  }
  for (std::size_t i = 0; i + 1 < findings_.size() && loops.empty(); ++i) {
    if (!Agree(findings_[i].finding, finding)) continue;
    for (Remembered* one : {&findings_[i], &findings_.back()}) {
      if (std::exchange(one->is_loop, true)) continue;
      if (const auto loop = Make(one->finding)) loops.push_back(*loop);
    }
  }
  return loops;
}

}  // namespace crsm
