#include "common/graph/loop_search.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "common/graph/draw_scans.hpp"
#include "common/graph/place_search.hpp"
#include "common/match/global_search.hpp"
#include "common/match/scored_map.hpp"
#include "common/match/summit.hpp"

namespace crsm {
namespace {

constexpr double kSubmapReach_m = 12.0;  ///< of the path, to either side of its middle
constexpr double kRecent_m = 8.0;        ///< of the path: what was seen there is looked for
constexpr double kFarthestPoint_m = 15.0;
constexpr double kCell_m = 0.05;
constexpr double kLeastScoreOfPlace = 0.55;
constexpr double kRivalShare = 0.9;  ///< corridors are alike every few metres
constexpr int kMostEvaluations = 60'000;
constexpr double kLeastScoreAnywhere = 0.8;  ///< in a window so wide chance finds more than in a small one
constexpr int kMostAnywhere = 20'000;        ///< a submap that takes longer is clutter, where anything fits

/// Part of a trajectory, by its keyframes, both ends included.
struct Submap {
  KeyframeId middle;
  KeyframeId first;
  KeyframeId last;
};

Submap MakeSubmap(const KeyframeGraph& graph, KeyframeId middle, KeyframeId newest) {
  const double middle_m = graph.path_m(middle);
  const KeyframeId latest = graph.FindByPath(newest.trajectory, graph.path_m(newest) - kLongAgo_m);
  return {middle, graph.FindByPath(middle.trajectory, middle_m - kSubmapReach_m),
          std::min(graph.FindByPath(middle.trajectory, middle_m + kSubmapReach_m), latest)};
}

/// Hits of some keyframes nearer than `farthest_m` to their laser and to a place in the frame of the middle one. 2 x N.
Eigen::Matrix2Xd CollectHits(const KeyframeGraph& graph, const Submap& part, const Pose2& place, double farthest_m) {
  const Eigen::Vector2d place_m(place.x_m, place.y_m);
  std::vector<Eigen::Vector2d> all;
  Pose2 T_frame_at = graph.Motion(part.middle, part.first);
  for (KeyframeId at = part.first; at <= part.last; ++at.number) {
    if (at > part.first) T_frame_at = T_frame_at * graph.keyframe(at).T_previous_this;
    const Eigen::Matrix2Xd hits_m = ComputeHits(graph.keyframe(at).rays);
    const auto [sin, cos] = ComputeSinCos(T_frame_at.yaw_rad);
    for (Eigen::Index k = 0; k < hits_m.cols(); ++k) {
      const Eigen::Vector2d hit_m(T_frame_at.x_m + cos * hits_m(0, k) - sin * hits_m(1, k),
                                  T_frame_at.y_m + sin * hits_m(0, k) + cos * hits_m(1, k));
      const double distance2_m2 = std::max(hits_m.col(k).squaredNorm(), (hit_m - place_m).squaredNorm());
      if (distance2_m2 < farthest_m * farthest_m) all.push_back(hit_m);
    }
  }
  Eigen::Matrix2Xd points_m(2, static_cast<Eigen::Index>(all.size()));
  for (std::size_t i = 0; i < all.size(); ++i) points_m.col(static_cast<Eigen::Index>(i)) = all[i];
  return points_m;
}

/// What was seen on the last metres, in the frame of the newest keyframe: one point of each small square, and few.
Eigen::Matrix2Xd CollectRecentPoints(const KeyframeGraph& graph, KeyframeId newest) {
  constexpr double kSquare_m = 0.1;
  constexpr Eigen::Index kMostPoints = 300;
  const Submap recent{newest, graph.FindByPath(newest.trajectory, graph.path_m(newest) - kRecent_m), newest};
  const Eigen::Matrix2Xd hits_m = CollectHits(graph, recent, {}, kFarthestPoint_m);
  std::unordered_set<std::int64_t> taken;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const auto x = static_cast<std::int64_t>(std::floor(hits_m(0, i) / kSquare_m));
    const auto y = static_cast<std::int64_t>(std::floor(hits_m(1, i) / kSquare_m));
    if (taken.insert(x * (std::int64_t{1} << 32) + y).second) kept.push_back(i);
  }
  const auto num_kept = static_cast<Eigen::Index>(kept.size());
  Eigen::Matrix2Xd points_m(2, std::min(num_kept, kMostPoints));
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    points_m.col(i) = hits_m.col(kept[static_cast<std::size_t>(i * num_kept / points_m.cols())]);
  }
  return points_m;
}

double Distance(const Pose2& a, const Pose2& b) { return Length({a.x_m - b.x_m, a.y_m - b.y_m, 0.0}); }

/// How far poses may have drifted apart.
struct Drift {
  double reach_m;
  double reach_rad;
};

/// What drift grows by on the way.
struct DriftModel {
  double m_per_m;
  double rad_per_m;

  Drift Over(double way_m) const {
    return {std::min(1.0 + m_per_m * way_m, 15.0), std::min(0.1 + rad_per_m * way_m, 0.6)};
  }
};

constexpr DriftModel kUsual{0.005, 0.00015};
constexpr DriftModel kLargest{0.02, 0.0006};  ///< with a slip in a corridor

struct Candidate {
  KeyframeId middle;  ///< of a submap
  double way_m;       ///< over which the poses may have drifted apart
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

/// What was driven since a keyframe, without what nobody knows of: the poses may have drifted apart over it.
double ComputeDriven(const KeyframeGraph& graph, KeyframeId older, KeyframeId newest) {
  double driven_m = graph.path_m(newest) - graph.path_m(older);
  for (int i = older.trajectory; i < newest.trajectory; ++i) driven_m += graph.path_m(graph.LastOf(i));
  return driven_m;
}

Candidates FindCandidates(const KeyframeGraph& graph, KeyframeId newest, double local_map_m, const DriftModel& drift) {
  constexpr double kPassing_m = 2.0;  // from one path to the other, where they meet
  constexpr double kKnown_m = 2.5;
  constexpr double kSurelyFar = 0.5;  // of what is too far: loops have hardly made the path twice as long
  Candidates found;
  std::optional<Ways> ways;  // not looked for before there is something near
  double nearest_m = kKnown_m;
  std::pair last_slot{-1, -1};  // trajectory, and which part of it
  for (std::optional<KeyframeId> i = KeyframeId{}; IsLongAgo(graph, *i);) {
    const double by_path_m = ComputeDriven(graph, *i, newest);
    const double away_m = Distance(graph.pose(*i), graph.pose(newest));
    const double beyond_m = away_m - drift.Over(by_path_m).reach_m - kPassing_m;
    if (beyond_m > 0.0) {  // and so are those of the next metres
      const double near_m = graph.path_m(*i) + kSurelyFar * beyond_m;
      i = std::max(*graph.After(*i), graph.FindByPath(i->trajectory, near_m));
      continue;
    }
    const KeyframeId at = *i;
    i = graph.After(at);
    if (!graph.HangTogether(at, newest)) continue;
    if (!ways) ways.emplace(graph, newest, local_map_m);
    // A way through the graph that is much longer than the crow flies is not agreement: the chain may be bent.
    const double way_m = std::min(ways->To(at), by_path_m);
    if (way_m <= local_map_m && way_m <= 12.0 + 2.0 * away_m) {
      if (away_m < nearest_m) {
        nearest_m = away_m;
        found.known = at;
      }
      continue;
    }
    if (away_m > drift.Over(way_m).reach_m + kPassing_m) continue;
    const std::pair slot{at.trajectory, static_cast<int>(graph.path_m(at) / kSubmapReach_m)};
    if (slot != last_slot) {
      found.unknown.push_back({graph.FindByPath(at.trajectory, (slot.second + 0.5) * kSubmapReach_m), way_m});
    } else {
      found.unknown.back().way_m = std::max(found.unknown.back().way_m, way_m);
    }
    last_slot = slot;
  }
  return found;
}

/// The middles of submaps that cover all components but that of the newest keyframe. What is shorter than a join takes
/// is left out: a hand before the laser makes a trajectory of one scan, too.
std::vector<KeyframeId> FindSubmapsElsewhere(const KeyframeGraph& graph) {
  constexpr double kLeastLength_m = 2.0;
  std::vector<KeyframeId> middles;
  for (int trajectory = 0; trajectory < graph.num_trajectories(); ++trajectory) {
    if (graph.HangTogether({trajectory, 0}, *graph.newest())) continue;
    const double length_m = graph.path_m(graph.LastOf(trajectory));
    if (length_m < kLeastLength_m) continue;
    const int num_submaps = static_cast<int>(length_m / kSubmapReach_m) + 1;
    for (int i = 0; i < num_submaps; ++i) {
      middles.push_back(graph.FindByPath(trajectory, (i + 0.5) * length_m / num_submaps));
    }
  }
  return middles;
}

/// Searches of one newest keyframe.
class PlaceFinder {
 public:
  PlaceFinder(const KeyframeGraph& graph, KeyframeId newest)
      : graph_(graph), newest_(newest), points_m_(CollectRecentPoints(graph, newest)) {}

  bool HasEnough() const { return points_m_.cols() >= 100; }

  /// least_score: what is worse is of no interest.
  Place Find(const HitPyramid& pyramid, KeyframeId middle, const Drift& drift, double least_score,
             int most_evaluations = kMostEvaluations) const {
    return FindPlace(pyramid, points_m_, {PresumedIn(middle), drift.reach_m, drift.reach_rad},
                     {kFarthestPoint_m, least_score, kRivalShare, most_evaluations});
  }

  /// Of what the points may come to lie on in a window of that reach.
  HitPyramid MakePyramid(KeyframeId middle, double reach_m) const {
    const Submap submap = MakeSubmap(graph_, middle, newest_);
    return HitPyramid(CollectHits(graph_, submap, PresumedIn(middle), reach_m + kFarthestPoint_m), kCell_m);
  }

  /// Anywhere near the middle of a submap, in any direction.
  Place FindAnywhere(KeyframeId middle, double least_score) const {
    constexpr double kReach_m = 8.0;
    const Submap submap = MakeSubmap(graph_, middle, newest_);
    const HitPyramid pyramid(CollectHits(graph_, submap, {}, kReach_m + kFarthestPoint_m), kCell_m);
    const Place place =
        FindPlace(pyramid, points_m_, {{}, kReach_m, kPi}, {kFarthestPoint_m, least_score, kRivalShare, kMostAnywhere});
    return place.evaluations > kMostAnywhere ? Place{} : place;
  }

  /// Where the matches say that the robot is: if it fits there, whether nowhere nearby as well; else further away.
  Place Check(KeyframeId middle) const {
    constexpr double kFine = 0.6;
    constexpr int kFew = 5000;  // a place that takes longer is like others
    constexpr Drift kFar{6.0, 0.2};
    const HitPyramid pyramid = MakePyramid(middle, kFar.reach_m);
    const bool fits = Find(pyramid, middle, {0.3, 0.03}, kLeastScoreOfPlace).score >= kFine;
    return fits ? Find(pyramid, middle, {2.5, 0.1}, kLeastScoreOfPlace, kFew)
                : Find(pyramid, middle, kFar, kLeastScoreOfPlace);
  }

 private:
  Pose2 PresumedIn(KeyframeId middle) const { return Inverse(graph_.pose(middle)) * graph_.pose(newest_); }

  const KeyframeGraph& graph_;
  KeyframeId newest_;
  Eigen::Matrix2Xd points_m_;
};

/// The best place of some submaps, and how well the best other place fits.
class BestFinding {
 public:
  explicit BestFinding(const KeyframeGraph& graph) : graph_(graph) {}

  /// What a place must have to matter: it is better, or a rival.
  double LeastScore(double least) const { return std::max(least, best_ ? kRivalShare * best_->score : 0.0); }

  void Add(KeyframeId middle, const Place& place) {
    constexpr double kSamePlace_m = 0.6;
    if (place.score == 0.0) return;
    rival_ = std::max(rival_, place.rival);
    const LoopFinding finding{middle, *graph_.newest(), place.pose, place.score};
    const auto PoseOf = [&](const LoopFinding& of) { return graph_.pose(of.older) * of.T_older_newer; };
    if (best_ && graph_.HangTogether(middle, best_->older) &&
        Distance(PoseOf(finding), PoseOf(*best_)) > kSamePlace_m) {
      rival_ = std::max(rival_, std::min(place.score, best_->score));
    }
    if (!best_ || place.score > best_->score) best_ = finding;
  }

  /// Nothing where another place fits nearly as well.
  std::optional<LoopFinding> Unrivalled() const {
    return best_ && rival_ <= kRivalShare * best_->score ? best_ : std::nullopt;
  }

 private:
  const KeyframeGraph& graph_;
  std::optional<LoopFinding> best_;
  double rival_ = 0.0;
};

/// Where the robot is of the places for which the graph does not vouch. known_score: of one that is known.
std::optional<LoopFinding> SearchUnknown(const KeyframeGraph& graph, const Candidates& candidates,
                                         const DriftModel& drift_model, double known_score) {
  if (candidates.unknown.empty()) return std::nullopt;
  const PlaceFinder finder(graph, *graph.newest());
  if (!finder.HasEnough()) return std::nullopt;
  BestFinding best(graph);
  for (const auto& [middle, way_m] : candidates.unknown) {
    const Drift drift = drift_model.Over(way_m);
    const double least_score = best.LeastScore(std::max(kLeastScoreOfPlace, kRivalShare * known_score));
    best.Add(middle, finder.Find(finder.MakePyramid(middle, drift.reach_m), middle, drift, least_score));
  }
  return best.Unrivalled();
}

/// Soon after a break the robot is near where it was before it: less has to fit there than in a window of any size.
std::optional<LoopFinding> SearchBeforeBreak(const KeyframeGraph& graph, const PlaceFinder& finder) {
  constexpr double kSoon_m = 15.0;
  constexpr double kBefore_m = 8.0;
  constexpr Drift kWindow{3.0, 0.5};
  const KeyframeId newest = *graph.newest();
  if (newest.trajectory == 0 || graph.path_m(newest) > kSoon_m) return std::nullopt;
  const KeyframeId last = graph.LastOf(newest.trajectory - 1);
  if (graph.HangTogether(last, newest)) return std::nullopt;
  const KeyframeId middle = graph.FindByPath(last.trajectory, graph.path_m(last) - kBefore_m);
  BestFinding best(graph);
  best.Add(middle, finder.Find(finder.MakePyramid(middle, kWindow.reach_m), middle, kWindow, kLeastScoreOfPlace));
  return best.Unrivalled();
}

/// Near any of the middles of submaps.
std::optional<LoopFinding> SearchAnywhere(const KeyframeGraph& graph, const PlaceFinder& finder,
                                          const std::vector<KeyframeId>& middles) {
  BestFinding best(graph);
  for (const KeyframeId middle : middles) {
    best.Add(middle, finder.FindAnywhere(middle, best.LeastScore(kLeastScoreAnywhere)));
  }
  return best.Unrivalled();
}

/// Whether the robot is where the matches say.
std::optional<LoopFinding> CheckKnown(const KeyframeGraph& graph, KeyframeId middle) {
  const KeyframeId newest = *graph.newest();
  const PlaceFinder finder(graph, newest);
  if (!finder.HasEnough()) return std::nullopt;
  const Place place = finder.Check(middle);
  if (place.score == 0.0 || place.rival > kRivalShare * place.score) return std::nullopt;
  return LoopFinding{middle, newest, place.pose, place.score, true};
}

}  // namespace

std::optional<LoopFinding> SearchLoop(const KeyframeGraph& graph, double local_map_m, bool thoroughly) {
  const KeyframeId newest = *graph.newest();
  double known_score = 0.0;
  if (!thoroughly) {
    const auto likely = SearchUnknown(graph, FindCandidates(graph, newest, local_map_m, kUsual), kUsual, 0.0);
    if (!likely) return std::nullopt;
    known_score = likely->score;
  }
  const Candidates candidates = FindCandidates(graph, newest, local_map_m, kLargest);
  if (thoroughly && candidates.unknown.empty() && candidates.known) return CheckKnown(graph, *candidates.known);
  return SearchUnknown(graph, candidates, kLargest, known_score);
}

std::optional<LoopFinding> SearchElsewhere(const KeyframeGraph& graph) {
  const std::vector<KeyframeId> middles = FindSubmapsElsewhere(graph);
  if (middles.empty()) return std::nullopt;
  const PlaceFinder finder(graph, *graph.newest());
  if (!finder.HasEnough()) return std::nullopt;
  if (const auto finding = SearchBeforeBreak(graph, finder)) return finding;
  return SearchAnywhere(graph, finder, middles);
}

std::optional<Loop> MakeLoop(const KeyframeGraph& graph, const LoopFinding& finding, const UpdateParameters& drawing) {
  constexpr double kSummit_rad = 0.02;
  const Submap submap = MakeSubmap(graph, finding.older, finding.newer);
  std::vector<PlacedScan> scans;
  for (KeyframeId at = submap.first; at <= submap.last; ++at.number) {
    scans.push_back({&graph.keyframe(at).rays, graph.Motion(finding.older, at)});
  }
  const ScoredMap map(DrawScans(drawing, scans), 0.0, true);
  const RaysInCells rays = map.InCells(CollectRecentPoints(graph, finding.newer));
  const auto Fitness = [&](const Pose2& at) { return map.Fitness(rays, at); };
  const auto SmoothFitness = [&](const Pose2& at) { return map.SmoothFitness(rays, at); };
  const Pose2 pose = FindSummit(finding.T_older_newer, kCell_m, kSummit_rad, Fitness, SmoothFitness);

  // Of 118 right loops the lowest two had 0.25 and 0.30, nine in ten more than 0.49.
  constexpr double kLeastAgreement = 0.2;
  const Eigen::Matrix2Xd newest_hits_m = ComputeHits(graph.keyframe(finding.newer).rays);
  if (ComputeAgreement(map.cells(), newest_hits_m, pose) < kLeastAgreement) return std::nullopt;
  const auto nearest = std::min_element(scans.begin(), scans.end(), [&](const PlacedScan& a, const PlacedScan& b) {
    return Distance(a.T_map_laser, pose) < Distance(b.T_map_laser, pose);
  });
  const int number = submap.first.number + static_cast<int>(nearest - scans.begin());
  return Loop{{submap.first.trajectory, number}, finding.newer, Inverse(nearest->T_map_laser) * pose};
}

}  // namespace crsm
