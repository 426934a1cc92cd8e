#include "common/graph/keyframe_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <set>
#include <utility>

namespace crsm {
namespace {

// How well motions are known. A match is good to a fifth of a cell of 0.05 m; along an open axis to a cell, since there
// the motion before decides; over lost scans nobody knows. A loop is matched on a map whose own parts have drifted.
constexpr MotionSigma kMotion{0.01, 0.01, 0.0015};
constexpr double kAlongOpenAxis_m = 0.05;
constexpr double kAcrossLost = 10.0;  ///< times as much
constexpr MotionSigma kLoop{0.03, 0.03, 0.005};
/// Over a break nobody knows anything. It keeps components that hang on nothing from drifting while others are solved.
constexpr MotionSigma kBreak{100.0, 100.0, 10.0};
constexpr double kContradicted = 36.0;  ///< a loop's squared error, in standard deviations: six of them

/// What the match of a keyframe tells of where it is, seen from an older one.
GraphEdge MakeMatchedEdge(int older, int index, const Pose2& T_older_this, const Keyframe& keyframe) {
  MotionSigma sigma = kMotion;
  Eigen::Vector2d axis = Eigen::Vector2d::UnitX();
  if (keyframe.open_axis) {
    const auto [sin, cos] = ComputeSinCos(T_older_this.yaw_rad);
    const Eigen::Vector2d& open = *keyframe.open_axis;
    axis = {cos * open.x() - sin * open.y(), sin * open.x() + cos * open.y()};
    sigma.x_m = kAlongOpenAxis_m;
  }
  if (keyframe.after_lost && older == index - 1) {
    sigma = {kAcrossLost * sigma.x_m, kAcrossLost * sigma.y_m, kAcrossLost * sigma.yaw_rad};
  }
  return GraphEdge::Make(older, index, T_older_this, sigma, axis);
}

bool HardlyDiffer(const Pose2& a, const Pose2& b) {
  constexpr double kHardly = 1e-6;  // [m] and [rad]
  return std::abs(a.x_m - b.x_m) < kHardly && std::abs(a.y_m - b.y_m) < kHardly &&
         std::abs(a.yaw_rad - b.yaw_rad) < kHardly;
}

GraphEdge MakeLoopEdge(const Loop& loop) {
  GraphEdge edge = GraphEdge::Make(loop.older, loop.newer, loop.T_older_newer, kLoop);
  edge.may_be_wrong = true;
  return edge;
}

}  // namespace

int KeyframeGraph::Add(Keyframe keyframe) {
  const int index = size();
  const Pose2& motion = keyframe.T_previous_this;
  keyframe.begins = keyframe.begins || index == 0;
  links_.emplace_back();
  poses_.push_back(index == 0 ? Pose2{} : poses_.back() * motion);
  path_m_.push_back(index == 0 ? 0.0 : path_m_.back() + (keyframe.begins ? kBreak_m : Length(motion)));
  if (keyframe.begins) first_of_.push_back(index);
  trajectory_of_.push_back(num_trajectories() - 1);
  if (keyframe.begins) {
    components_.push_back(trajectory_of_.back());
    ++num_components_;
  }
  if (!keyframe.begins) Link(index - 1, index, Length(motion));
  if (keyframe.tie && !keyframe.tie_wrong) Link(keyframe.tie->keyframe, index, Length(keyframe.tie->T_keyframe_this));
  keyframes_.push_back(std::move(keyframe));
  return index;
}

void KeyframeGraph::AddLoop(const Loop& loop) {
  loops_.push_back(loop);
  Link(loop.older, loop.newer, Length(loop.T_older_newer));
  if (trajectory(loop.older) != trajectory(loop.newer)) UpdateComponents();
}

void KeyframeGraph::DropLoop(const Loop& loop) {
  const auto found = std::find(loops_.begin(), loops_.end(), loop);
  if (found == loops_.end()) return;
  Unlink(loop.older, loop.newer, Length(loop.T_older_newer));
  loops_.erase(found);
  ++num_loops_dropped_;
  if (trajectory(loop.older) != trajectory(loop.newer)) UpdateComponents();
}

void KeyframeGraph::DropTies(int first) {
  for (int i = first; i < size(); ++i) {
    Keyframe& at = keyframes_[static_cast<std::size_t>(i)];
    if (at.tie && !std::exchange(at.tie_wrong, true)) Unlink(at.tie->keyframe, i, Length(at.tie->T_keyframe_this));
  }
}

std::vector<int> KeyframeGraph::FindComponents(const std::vector<Loop>& loops) const {
  std::vector<int> components(first_of_.size());
  std::iota(components.begin(), components.end(), 0);
  for (const Loop& loop : loops) {
    const int a = components[static_cast<std::size_t>(trajectory(loop.older))];
    const int b = components[static_cast<std::size_t>(trajectory(loop.newer))];
    if (a != b) std::replace(components.begin(), components.end(), std::max(a, b), std::min(a, b));
  }
  return components;
}

void KeyframeGraph::UpdateComponents() {
  components_ = FindComponents(loops_);
  num_components_ = static_cast<int>(std::set(components_.begin(), components_.end()).size());
}

void KeyframeGraph::Join(const Loop& loop) {
  if (HangTogether(loop.older, loop.newer)) return;
  const bool newer_moves = component(loop.newer) > component(loop.older);
  const int moving = newer_moves ? component(loop.newer) : component(loop.older);
  const Pose2 T_new_old = newer_moves ? pose(loop.older) * loop.T_older_newer * Inverse(pose(loop.newer))
                                      : pose(loop.newer) * Inverse(loop.T_older_newer) * Inverse(pose(loop.older));
  for (int i = 0; i < size(); ++i) {
    Pose2& at = poses_[static_cast<std::size_t>(i)];
    if (component(i) == moving) at = T_new_old * at;
  }
}

int KeyframeGraph::FindByPath(double path_m) const {
  const auto next = std::lower_bound(path_m_.begin(), path_m_.end(), path_m);
  return std::min(static_cast<int>(next - path_m_.begin()), size() - 1);
}

Pose2 KeyframeGraph::Motion(int from, int to) const {
  Pose2 motion;
  for (int i = std::min(from, to) + 1; i <= std::max(from, to); ++i) motion = motion * keyframe(i).T_previous_this;
  return from <= to ? motion : Inverse(motion);
}

std::vector<std::pair<int, double>> KeyframeGraph::FindWithin(int from, double reach_m) const {
  using Node = std::pair<double, int>;  // distance first: the nearest is at the top
  std::priority_queue<Node, std::vector<Node>, std::greater<>> front;
  std::vector<double> distance_m(keyframes_.size(), HUGE_VAL);
  std::vector<std::pair<int, double>> found;
  distance_m[static_cast<std::size_t>(from)] = 0.0;
  front.emplace(0.0, from);
  while (!front.empty()) {
    const auto [distance, at] = front.top();
    front.pop();
    if (distance > distance_m[static_cast<std::size_t>(at)]) continue;
    found.emplace_back(at, distance);
    for (const auto& [next, length_m] : links_[static_cast<std::size_t>(at)]) {
      if (!HangTogether(at, next)) continue;  // a tie that was made while they did
      const double there_m = distance + length_m;
      double& known_m = distance_m[static_cast<std::size_t>(next)];
      if (there_m > reach_m || there_m >= known_m) continue;
      known_m = there_m;
      front.emplace(there_m, next);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

PoseGraph KeyframeGraph::MakePoseGraph() const {
  PoseGraph graph;
  for (const Pose2& pose : poses_) graph.AddPose(pose);
  for (int i = 1; i < size(); ++i) {
    const Keyframe& at = keyframe(i);
    graph.AddEdge(MakeMotionEdge(i));
    if (!at.tie || at.tie_wrong || !HangTogether(at.tie->keyframe, i)) continue;
    graph.AddEdge(MakeMatchedEdge(at.tie->keyframe, i, at.tie->T_keyframe_this, at));
  }
  for (const Loop& loop : loops_) graph.AddEdge(MakeLoopEdge(loop));
  return graph;
}

/// Since the keyframe before. Over a break, where nothing is known, the poses as they are.
GraphEdge KeyframeGraph::MakeMotionEdge(int index) const {
  const Keyframe& at = keyframe(index);
  if (!at.begins) return MakeMatchedEdge(index - 1, index, at.T_previous_this, at);
  return GraphEdge::Make(index - 1, index, Inverse(pose(index - 1)) * pose(index), kBreak);
}

std::vector<Loop> KeyframeGraph::Optimise() {
  PoseGraph graph = MakePoseGraph();
  graph.Optimise();
  std::size_t first = 0;
  while (first < poses_.size() && HardlyDiffer(poses_[first], graph.poses()[first])) ++first;
  std::copy(graph.poses().begin() + static_cast<std::ptrdiff_t>(first), graph.poses().end(),
            poses_.begin() + static_cast<std::ptrdiff_t>(first));
  std::vector<Loop> contradicted;
  for (const Loop& loop : loops_) {
    if (graph.SquaredError(MakeLoopEdge(loop)) > kContradicted) contradicted.push_back(loop);
  }
  for (const Loop& loop : contradicted) DropLoop(loop);
  return contradicted;
}

void KeyframeGraph::Apply(const GraphUpdate& update) {
  for (const Loop& loop : update.closed) AddLoop(loop);
  for (const Loop& loop : update.taken_out) DropLoop(loop);
  if (update.ties_wrong_from) DropTies(*update.ties_wrong_from);
  PutRight(update, poses_);
}

void KeyframeGraph::PutRight(const GraphUpdate& update, std::vector<Pose2>& poses) const {
  std::copy(update.poses.begin(), update.poses.end(), poses.begin() + update.first_pose);
  for (auto i = static_cast<std::size_t>(update.keyframe) + 1; i < poses.size(); ++i) {
    poses[i] = poses[i - 1] * keyframes_[i].T_previous_this;
  }
}

bool KeyframeGraph::Fits(const GraphUpdate& update) const {
  const auto IsOlder = [&](const Loop& loop) {
    return loop.older >= 0 && loop.older < loop.newer && loop.newer <= update.keyframe;
  };
  const auto IsOnAnyMap = [](const Pose2& pose) {
    constexpr double kFarthest_m = 1e5;  // no map is so large
    return std::abs(pose.x_m) < kFarthest_m && std::abs(pose.y_m) < kFarthest_m;
  };
  return update.keyframe >= 0 && update.keyframe < size() && update.previous >= -1 &&
         std::all_of(update.poses.begin(), update.poses.end(), IsOnAnyMap) && update.previous < update.keyframe &&
         std::all_of(update.closed.begin(), update.closed.end(), IsOlder) &&
         std::all_of(update.taken_out.begin(), update.taken_out.end(), IsOlder) &&
         update.ties_wrong_from.value_or(0) >= 0 && update.first_pose >= 0 &&
         std::cmp_equal(update.first_pose + std::ssize(update.poses), update.keyframe + 1);
}

void KeyframeGraph::Link(int a, int b, double length_m) {
  links_[static_cast<std::size_t>(a)].emplace_back(b, length_m);
  links_[static_cast<std::size_t>(b)].emplace_back(a, length_m);
}

void KeyframeGraph::Unlink(int a, int b, double length_m) {
  const auto Drop = [&](int at, int to) {
    auto& links = links_[static_cast<std::size_t>(at)];
    const auto found = std::find(links.begin(), links.end(), std::pair(to, length_m));
    if (found != links.end()) links.erase(found);
  };
  Drop(a, b);
  Drop(b, a);
}

}  // namespace crsm
