#include "common/graph/mapper.hpp"

#include <cmath>
#include <numeric>
#include <utility>

#include "common/graph/draw_scans.hpp"

namespace crsm {

Mapper::Mapper(const UpdateParameters& drawing, const LoopParameters& loops)
    : drawing_(drawing), loops_(loops), local_(drawing) {}

Mapper::Step Mapper::Integrate(const CriticalRays* scan, const ScanMatch& match) {
  constexpr double kPeriod_m = 20.0;
  Step step{scan ? local_.Update(*scan, match) : local_.UpdateWithoutScan()};
  if (!loops_.loops) return step;
  if (match.state == MatchState::kLost) lost_since_ = true;
  if (step.delta.drawn) AddKeyframe(scan->rays, match);
  if (graph_.size() == 0) {
    scans_.push_back({0, match.T_map_laser});
    return step;
  }
  const int newest = graph_.size() - 1;
  scans_.push_back({newest, Inverse(graph_.pose(newest)) * match.T_map_laser});
  if (!step.delta.drawn) return step;
  step.keyframe = &graph_.keyframe(newest);
  if (graph_.path_m(newest) - looked_at_m_ < kPeriod_m) return step;
  looked_at_m_ = graph_.path_m(newest);
  const std::vector<int> local = FindLocal();
  if (local == drawn_) return step;
  const std::vector<TileChange> tiles = Draw(local);
  step.delta.tiles.insert(step.delta.tiles.end(), tiles.begin(), tiles.end());
  return step;
}

std::optional<Mapper::Correction> Mapper::Apply(const GraphUpdate& update) {
  if (update.poses.empty()) return std::nullopt;
  const Pose2 before = graph_.poses().back();
  graph_.Apply(update);
  looked_at_m_ = graph_.path_m(graph_.size() - 1);
  return Correction{Draw(FindLocal()), graph_.poses().back() * Inverse(before)};
}

std::vector<TileChange> Mapper::Finish() {
  std::vector<int> all(static_cast<std::size_t>(graph_.size()));
  std::iota(all.begin(), all.end(), 0);
  std::vector<TileChange> tiles;
  if (loops_.loops) tiles = Draw(all);
  local_.Finish();
  return tiles;
}

ByteMap Mapper::DrawWhole(const KeyframeGraph& graph) const {
  std::vector<PlacedScan> scans;
  for (int i = 0; i < graph.size(); ++i) scans.push_back({&graph.keyframe(i).rays, graph.pose(i)});
  return DrawScans(drawing_, scans);
}

std::vector<Pose2> Mapper::CorrectedPoses(const KeyframeGraph& graph) const {
  std::vector<Pose2> poses;
  for (const auto& [keyframe, T_keyframe_laser] : scans_) {
    poses.push_back(graph.size() == 0 ? T_keyframe_laser : graph.pose(keyframe) * T_keyframe_laser);
  }
  return poses;
}

void Mapper::AddKeyframe(const ValidRays& rays, const ScanMatch& match) {
  Keyframe keyframe;
  keyframe.utime = match.utime;
  keyframe.rays = rays;
  keyframe.after_lost = std::exchange(lost_since_, false);
  if (graph_.size() > 0) {
    keyframe.T_previous_this = Inverse(graph_.poses().back()) * match.T_map_laser;
    keyframe.tie = FindTie(match.T_map_laser);
  }
  if (match.state == MatchState::kDegenerate) {
    const auto [sin, cos] = ComputeSinCos(match.T_map_laser.yaw_rad);
    const auto& [x, y] = match.degenerate_axis;
    keyframe.open_axis = Eigen::Vector2d(cos * x + sin * y, cos * y - sin * x);
  }
  drawn_.push_back(graph_.Add(std::move(keyframe)));
}

/// The nearest keyframe of long ago that is in the local map.
std::optional<Tie> Mapper::FindTie(const Pose2& T_map_laser) const {
  double nearest_m = 2.5;
  std::optional<Tie> tie;
  const double here_m = graph_.path_m(graph_.size() - 1);
  for (const int index : drawn_) {
    if (here_m - graph_.path_m(index) < kLongAgo_m) break;
    const Pose2 T_keyframe_laser = Inverse(graph_.pose(index)) * T_map_laser;
    const double distance_m = Length(T_keyframe_laser);
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    tie = Tie{index, T_keyframe_laser};
  }
  return tie;
}

/// The keyframes that belong into the local map, oldest first.
std::vector<int> Mapper::FindLocal() const {
  std::vector<int> local;
  for (const auto& near : graph_.FindWithin(graph_.size() - 1, loops_.local_map_m)) local.push_back(near.first);
  return local;
}

std::vector<TileChange> Mapper::Draw(const std::vector<int>& keyframes) {
  std::vector<PlacedScan> scans;
  for (const int index : keyframes) scans.push_back({&graph_.keyframe(index).rays, graph_.pose(index)});
  drawn_ = keyframes;
  return local_.DrawAnew(scans);
}

}  // namespace crsm
