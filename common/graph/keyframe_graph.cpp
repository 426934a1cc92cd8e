#include "common/graph/keyframe_graph.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <queue>
#include <set>
#include <utility>

#include "common/graph/keyframe_edges.hpp"

namespace crsm {
namespace {

/// Two trajectories hang together: those that hang together with either.
void Unite(std::vector<int>& groups, int trajectory, int other) {
  const int a = groups[static_cast<std::size_t>(trajectory)];
  const int b = groups[static_cast<std::size_t>(other)];
  if (a != b) std::replace(groups.begin(), groups.end(), std::max(a, b), std::min(a, b));
}

bool HardlyDiffer(const Pose2& a, const Pose2& b, double hardly) {
  return std::abs(a.x_m - b.x_m) < hardly && std::abs(a.y_m - b.y_m) < hardly &&
         std::abs(a.yaw_rad - b.yaw_rad) < hardly;
}

/// Where a pose graph of all keyframes has them: in the order of their names, from 0.
class PoseIndices {
 public:
  explicit PoseIndices(const KeyframeGraph& graph) {
    for (int i = 0, first = 0; i < graph.num_trajectories(); first += graph.size(i++)) first_of_.push_back(first);
  }
  int operator()(KeyframeId id) const { return first_of_[static_cast<std::size_t>(id.trajectory)] + id.number; }

 private:
  std::vector<int> first_of_;  ///< by trajectory
};

/// Matches in a row err alike.
MotionSigma Correlate(const MotionSigma& sigma, double correlated) {
  const double times = std::sqrt(correlated);
  return {times * sigma.x_m, times * sigma.y_m, times * sigma.yaw_rad};
}

}  // namespace

KeyframeId KeyframeGraph::Add(Keyframe keyframe) {
  const auto before = newest();
  const Pose2& motion = keyframe.T_previous_this;
  const Pose2 pose = before ? this->pose(*before) * motion : Pose2{};
  keyframe.begins = keyframe.begins || !before;
  if (before) keyframe.rays.ShareAngles(this->keyframe(*before).rays);
  if (keyframe.begins) {
    components_.push_back(num_trajectories());
    pieces_.push_back(before && keyframe.by_wheels ? pieces_.back() : num_trajectories());
    ++num_components_;
    trajectories_.emplace_back();
    poses_.emplace_back();
  }
  ++size_;
  Trajectory& trajectory = trajectories_.back();
  trajectory.path_m.push_back(keyframe.begins ? 0.0 : trajectory.path_m.back() + Length(motion));
  trajectory.links.emplace_back();
  trajectory.keyframes.push_back(std::move(keyframe));
  poses_.back().push_back(pose);
  const KeyframeId id = LastOf(num_trajectories() - 1);
  const Keyframe& added = trajectory.keyframes.back();
  if (!added.begins) Link(*before, id, Length(added.T_previous_this));
  if (added.constraint && !added.constraint_wrong)
    Link(added.constraint->keyframe, id, Length(added.constraint->T_keyframe_this));
  return id;
}

void KeyframeGraph::AddLoop(const Loop& loop) {
  const auto Names = [](const Loop& of) { return std::pair(of.newer, of.older); };
  loops_.insert(std::ranges::upper_bound(loops_, Names(loop), {}, Names), loop);
  Link(loop.older, loop.newer, Length(loop.T_older_newer));
  if (loop.older.trajectory != loop.newer.trajectory) UpdateComponents();
}

void KeyframeGraph::DropLoop(const Loop& loop) {
  const auto found = std::find(loops_.begin(), loops_.end(), loop);
  if (found == loops_.end()) return;
  Unlink(loop.older, loop.newer, Length(loop.T_older_newer));
  loops_.erase(found);
  ++num_loops_dropped_;
  if (loop.older.trajectory != loop.newer.trajectory) UpdateComponents();
}

void KeyframeGraph::DropConstraints(KeyframeId first) {
  for (std::optional<KeyframeId> id = first; id; id = After(*id)) {
    Keyframe& at = of(id->trajectory).keyframes[Index(*id)];
    if (at.constraint && !std::exchange(at.constraint_wrong, true))
      Unlink(at.constraint->keyframe, *id, Length(at.constraint->T_keyframe_this));
  }
}

bool KeyframeGraph::Has(KeyframeId id) const {
  return id.trajectory >= 0 && id.trajectory < num_trajectories() && id.number >= 0 && id.number < size(id.trajectory);
}

std::optional<KeyframeId> KeyframeGraph::newest() const {
  return size_ == 0 ? std::nullopt : std::optional(LastOf(num_trajectories() - 1));
}

std::optional<KeyframeId> KeyframeGraph::Before(KeyframeId id) const {
  if (id.number > 0) return KeyframeId{id.trajectory, id.number - 1};
  return id.trajectory > 0 ? std::optional(LastOf(id.trajectory - 1)) : std::nullopt;
}

std::optional<KeyframeId> KeyframeGraph::After(KeyframeId id) const {
  if (id < LastOf(id.trajectory)) return KeyframeId{id.trajectory, id.number + 1};
  return id.trajectory + 1 < num_trajectories() ? std::optional(KeyframeId{id.trajectory + 1, 0}) : std::nullopt;
}

int KeyframeGraph::CountAfter(KeyframeId id) const {
  int num = size(id.trajectory) - id.number - 1;
  for (int i = id.trajectory + 1; i < num_trajectories(); ++i) num += size(i);
  return num;
}

std::vector<KeyframeId> KeyframeGraph::ids() const {
  std::vector<KeyframeId> ids;
  for (int i = 0; i < num_trajectories(); ++i) {
    for (int k = 0; k < size(i); ++k) ids.push_back({i, k});
  }
  return ids;
}

std::vector<int> KeyframeGraph::FindComponents(const std::vector<Loop>& loops) const {
  std::vector<int> components(trajectories_.size());
  std::iota(components.begin(), components.end(), 0);
  for (const Loop& loop : loops) Unite(components, loop.older.trajectory, loop.newer.trajectory);
  return components;
}

std::vector<int> KeyframeGraph::FindPieces(const std::vector<Loop>& loops) const {
  std::vector<int> pieces = FindComponents(loops);
  for (int i = 1; i < num_trajectories(); ++i) {
    if (IsBridged(i)) Unite(pieces, i - 1, i);
  }
  return pieces;
}

bool KeyframeGraph::IsBridged(int trajectory) const {
  return trajectory > 0 && keyframe({trajectory, 0}).by_wheels.has_value();
}

std::optional<WheelMotion> KeyframeGraph::SumBridges(KeyframeId older, KeyframeId newer) const {
  const auto Piece = [&](KeyframeId id) { return pieces_[static_cast<std::size_t>(id.trajectory)]; };
  if (Piece(older) != Piece(newer)) return std::nullopt;
  std::optional<WheelMotion> sum;
  for (int i = older.trajectory + 1; i <= newer.trajectory; ++i) {
    if (!IsBridged(i)) continue;
    const WheelMotion& bridge = *keyframe({i, 0}).by_wheels;
    const Pose2 onward{Distance(pose({i, 0}), pose(newer)), 0.0, 0.0};  // over which an error of the heading grows
    const WheelMotion error = WheelMotion{{}, bridge.sigma_m, bridge.sigma_rad} * WheelMotion{onward, 0.0, 0.0};
    sum = sum.value_or(WheelMotion{}) * WheelMotion{{}, error.sigma_m, error.sigma_rad};
  }
  return sum;
}

std::vector<int> KeyframeGraph::CountKeyframes(const std::vector<int>& components) const {
  std::vector<int> counts(components.size(), 0);
  for (int i = 0; i < num_trajectories(); ++i) {
    counts[static_cast<std::size_t>(components[static_cast<std::size_t>(i)])] += size(i);
  }
  return counts;
}

std::optional<KeyframeId> KeyframeGraph::FindNearest(const Pose2& T_map_place, KeyframeId with, int before_trajectory,
                                                     double within_m) const {
  std::optional<KeyframeId> nearest;
  double nearest_m = within_m;
  for (std::optional<KeyframeId> id = KeyframeId{}; id && id->trajectory < before_trajectory; id = After(*id)) {
    if (!HangTogether(*id, with)) continue;
    const double away_m = Distance(pose(*id), T_map_place);
    if (away_m >= nearest_m) continue;
    nearest_m = away_m;
    nearest = id;
  }
  return nearest;
}

std::vector<Loop> KeyframeGraph::FindLoopsAcross(int trajectory) const {
  std::vector<Loop> across;
  std::ranges::copy_if(loops_, std::back_inserter(across), [&](const Loop& loop) {
    return loop.older.trajectory != loop.newer.trajectory &&
           (loop.older.trajectory == trajectory || loop.newer.trajectory == trajectory);
  });
  return across;
}

double KeyframeGraph::ComputeDriven(KeyframeId older, KeyframeId newer) const {
  double driven_m = path_m(newer) - path_m(older);
  for (int i = older.trajectory; i < newer.trajectory; ++i) driven_m += path_m(LastOf(i));
  return driven_m;
}

void KeyframeGraph::UpdateComponents() {
  components_ = FindComponents(loops_);
  pieces_ = FindPieces(loops_);
  num_components_ = static_cast<int>(std::set(components_.begin(), components_.end()).size());
}

void KeyframeGraph::Join(const Loop& loop) {
  if (HangTogether(loop.older, loop.newer)) return;
  const bool newer_moves = component(loop.newer) > component(loop.older);
  const int moving = newer_moves ? component(loop.newer) : component(loop.older);
  const Pose2 T_new_old = newer_moves ? pose(loop.older) * loop.T_older_newer * Inverse(pose(loop.newer))
                                      : pose(loop.newer) * Inverse(loop.T_older_newer) * Inverse(pose(loop.older));
  for (int i = 0; i < num_trajectories(); ++i) {
    if (components_[static_cast<std::size_t>(i)] != moving) continue;
    for (Pose2& at : poses_[static_cast<std::size_t>(i)]) at = T_new_old * at;
  }
}

KeyframeId KeyframeGraph::FindByPath(int trajectory, double path_m) const {
  const std::vector<double>& all_m = of(trajectory).path_m;
  const auto next = std::lower_bound(all_m.begin(), all_m.end(), path_m);
  return {trajectory, std::min(static_cast<int>(next - all_m.begin()), size(trajectory) - 1)};
}

Pose2 KeyframeGraph::Motion(KeyframeId from, KeyframeId to) const {
  Pose2 motion;
  for (int i = std::min(from, to).number + 1; i <= std::max(from, to).number; ++i) {
    motion = motion * keyframe({from.trajectory, i}).T_previous_this;
  }
  return from <= to ? motion : Inverse(motion);
}

std::vector<std::pair<KeyframeId, double>> KeyframeGraph::FindWithin(KeyframeId from, double reach_m) const {
  using Node = std::pair<double, KeyframeId>;  // distance first: the nearest is at the top
  std::priority_queue<Node, std::vector<Node>, std::greater<>> front;
  const PoseIndices indices(*this);
  std::vector<double> distance_m(static_cast<std::size_t>(size_), HUGE_VAL);
  const auto KnownDistance = [&](KeyframeId id) -> double& {
    return distance_m[static_cast<std::size_t>(indices(id))];
  };
  KnownDistance(from) = 0.0;
  front.emplace(0.0, from);
  while (!front.empty()) {
    const auto [distance, at] = front.top();
    front.pop();
    if (distance > KnownDistance(at)) continue;
    for (const auto& [next, length_m] : of(at.trajectory).links[Index(at)]) {
      if (!HangTogether(at, next)) continue;  // a constraint that was made while they did
      const double there_m = distance + length_m;
      double& known_m = KnownDistance(next);
      if (there_m > reach_m || there_m >= known_m) continue;
      known_m = there_m;
      front.emplace(there_m, next);
    }
  }
  std::vector<std::pair<KeyframeId, double>> found;
  KeyframeId at;
  for (const double known_m : distance_m) {
    if (known_m < HUGE_VAL) found.emplace_back(at, known_m);
    if (++at.number == size(at.trajectory)) at = {at.trajectory + 1, 0};
  }
  return found;
}

PoseGraph KeyframeGraph::MakePoseGraph() const {
  const PoseIndices indices(*this);
  PoseGraph graph(constants_.optimisation);
  for (const std::vector<Pose2>& trajectory : poses_) {
    for (const Pose2& pose : trajectory) graph.AddPose(pose);
  }
  for (KeyframeEdge& edge : FindEdges(*this, constants_)) {
    if (!edge.may_be_wrong()) edge.sigma = Correlate(edge.sigma, constants_.correlated);
    graph.AddEdge(ToGraphEdge(edge, indices(edge.older), indices(edge.newer)));
  }
  for (int i = 1; i < num_trajectories(); ++i) {
    if (IsBridged(i)) continue;
    const KeyframeId first{i, 0}, before = LastOf(i - 1);
    graph.AddEdge(
        GraphEdge::Make(indices(before), indices(first), Inverse(pose(before)) * pose(first), constants_.across_break));
  }
  return graph;
}

std::vector<Loop> KeyframeGraph::Optimise() {
  PoseGraph graph = MakePoseGraph();
  graph.Optimise();
  auto solved = graph.poses().begin();
  bool moves = false;
  for (std::vector<Pose2>& trajectory : poses_) {
    for (Pose2& pose : trajectory) {
      moves = moves || !HardlyDiffer(pose, *solved, constants_.hardly);
      if (moves) pose = *solved;
      ++solved;
    }
  }
  std::vector<Loop> contradicted;
  const PoseIndices indices(*this);
  for (const Loop& loop : loops_) {
    const double error =
        graph.SquaredError(ToGraphEdge(MakeEdge(loop, constants_), indices(loop.older), indices(loop.newer)));
    if (error > constants_.contradicted) contradicted.push_back(loop);
  }
  for (const Loop& loop : contradicted) DropLoop(loop);
  return contradicted;
}

void KeyframeGraph::Apply(const GraphUpdate& update) {
  for (const Loop& loop : update.closed) AddLoop(loop);
  for (const Loop& loop : update.rejected) DropLoop(loop);
  if (update.constraints_wrong_from) DropConstraints(*update.constraints_wrong_from);
  Move(update);
}

void KeyframeGraph::Correct(const GraphUpdate& update, KeyframePoses& poses) const {
  for (const PoseStretch& stretch : update.moved) {
    std::ranges::copy(stretch.poses,
                      poses[static_cast<std::size_t>(stretch.first.trajectory)].begin() + stretch.first.number);
  }
  Pose2 before = At(poses, update.keyframe);
  for (auto id = After(update.keyframe); id; id = After(*id)) {
    before = before * keyframe(*id).T_previous_this;
    poses[static_cast<std::size_t>(id->trajectory)][Index(*id)] = before;
  }
}

bool KeyframeGraph::Fits(const GraphUpdate& update) const {
  const auto WasThere = [&](KeyframeId id) { return Has(id) && id <= update.keyframe; };
  const auto IsLoop = [&](const Loop& loop) {
    return loop.older < loop.newer && WasThere(loop.older) && WasThere(loop.newer);
  };
  const auto IsFinding = [&](const LoopFinding& finding) {
    return finding.newer == update.keyframe && finding.older < finding.newer && Has(finding.older);
  };
  const auto IsOnAnyMap = [](const Pose2& pose) {
    constexpr double kFarthest_m = 1e5;  // no map is so large
    return std::abs(pose.x_m) < kFarthest_m && std::abs(pose.y_m) < kFarthest_m;
  };
  const auto IsStretch = [&](const PoseStretch& stretch) {
    return !stretch.poses.empty() && Has(stretch.first) &&
           std::cmp_less_equal(stretch.poses.size(), size(stretch.first.trajectory) - stretch.first.number) &&
           stretch.last() <= update.keyframe && std::ranges::all_of(stretch.poses, IsOnAnyMap);
  };
  const auto Overlap = [](const PoseStretch& a, const PoseStretch& b) { return a.last() >= b.first; };
  return Has(update.keyframe) && (!update.previous || (Has(*update.previous) && update.previous < update.keyframe)) &&
         (!update.finding || IsFinding(*update.finding)) && std::ranges::all_of(update.closed, IsLoop) &&
         std::ranges::all_of(update.rejected, IsLoop) &&
         (!update.constraints_wrong_from || WasThere(*update.constraints_wrong_from)) &&
         std::ranges::all_of(update.moved, IsStretch) &&
         std::ranges::adjacent_find(update.moved, Overlap) == update.moved.end();
}

void KeyframeGraph::Link(KeyframeId a, KeyframeId b, double length_m) {
  of(a.trajectory).links[Index(a)].emplace_back(b, length_m);
  of(b.trajectory).links[Index(b)].emplace_back(a, length_m);
}

void KeyframeGraph::Unlink(KeyframeId a, KeyframeId b, double length_m) {
  const auto Drop = [&](KeyframeId at, KeyframeId to) {
    Links& links = of(at.trajectory).links[Index(at)];
    const auto found = std::find(links.begin(), links.end(), std::pair(to, length_m));
    if (found != links.end()) links.erase(found);
  };
  Drop(a, b);
  Drop(b, a);
}

}  // namespace crsm
