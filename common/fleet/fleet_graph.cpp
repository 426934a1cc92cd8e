#include "common/fleet/fleet_graph.hpp"

#include <algorithm>
#include <numeric>

#include "common/graph/keyframe_edges.hpp"

namespace crsm {
namespace {

/// Two trajectories hang together: so do those that hang together with either.
void Unite(std::vector<int>& groups, int one, int other) {
  const int a = groups[static_cast<std::size_t>(one)];
  const int b = groups[static_cast<std::size_t>(other)];
  if (a != b) std::replace(groups.begin(), groups.end(), std::max(a, b), std::min(a, b));
}

/// Where a keyframe stands in a pose graph of whole maps. first_pose: of each map, -1 where it is not in the graph.
int IndexOf(const FleetKeyframeId& at, const KeyframeGraph& map, const std::vector<int>& first_pose) {
  int index = first_pose[static_cast<std::size_t>(at.map)] + at.id.number;
  for (int i = 0; i < at.id.trajectory; ++i) index += map.size(i);
  return index;
}

}  // namespace

int FleetGraph::AddMap(const KeyframeGraph& map) {
  maps_.push_back({&map, {}, {}});
  return num_maps() - 1;
}

void FleetGraph::AddNewest(int map) {
  Map& of = maps_[static_cast<std::size_t>(map)];
  const KeyframeGraph& graph = *of.graph;
  const KeyframeId newest = *graph.newest();
  const auto before = graph.Before(newest);
  const Pose2 pose = before ? At(of.poses, *before) * graph.keyframe(newest).T_previous_this : graph.pose(newest);
  if (newest.number == 0) {
    of.poses.emplace_back();
    of.trajectories.push_back(static_cast<int>(trajectories_.size()));
    trajectories_.emplace_back(map, newest.trajectory);
  }
  of.poses.back().push_back(pose);
  if (newest.number == 0) FindPieces();
}

void FleetGraph::TakeOver(int map, const GraphUpdate& update) {
  const std::int64_t num_layouts = num_layouts_;
  for (const Loop& loop : update.closed) Join({map, loop.older}, {map, loop.newer}, loop.T_older_newer);
  if (num_layouts_ == num_layouts && update.moved.empty() && update.rejected.empty()) return;
  Refresh();
}

void FleetGraph::AddLoop(const FleetLoop& loop) {
  const bool joins = !HangTogether(loop.older, loop.newer);
  const bool agrees = AreNear(Inverse(pose(loop.older)) * pose(loop.newer), loop.T_older_newer, constants_.agrees_m,
                              constants_.agrees_rad);
  Join(loop.older, loop.newer, loop.T_older_newer);
  loops_.push_back(loop);
  if (!joins && agrees) return;
  Refresh();
}

void FleetGraph::DropLoopsOf(const FleetKeyframeId& keyframe) {
  const int trajectory = TrajectoryOf(keyframe);
  std::erase_if(loops_, [&](const FleetLoop& loop) {
    const bool is_of_it = TrajectoryOf(loop.older) == trajectory || TrajectoryOf(loop.newer) == trajectory;
    if (is_of_it) rejected_.push_back(loop);
    return is_of_it;
  });
  Refresh();
}

void FleetGraph::FindPieces() {
  std::vector<int> pieces(trajectories_.size());
  std::iota(pieces.begin(), pieces.end(), 0);
  for (const Map& map : maps_) {
    for (std::size_t i = 0; i < map.trajectories.size(); ++i) {
      const auto oldest = static_cast<std::size_t>(map.graph->pieces()[i]);
      Unite(pieces, map.trajectories[i], map.trajectories[oldest]);
    }
  }
  for (const FleetLoop& loop : loops_) Unite(pieces, TrajectoryOf(loop.older), TrajectoryOf(loop.newer));
  if (pieces_.size() == pieces.size() && pieces_ != pieces) ++num_layouts_;
  pieces_ = std::move(pieces);
}

/// Moves the younger of two pieces to where it lies as seen from the other; nothing if they are one.
void FleetGraph::Join(const FleetKeyframeId& a, const FleetKeyframeId& b, const Pose2& T_a_b) {
  if (HangTogether(a, b)) return;
  const bool b_moves = piece(b) > piece(a);
  const int moving = b_moves ? piece(b) : piece(a);
  const int staying = b_moves ? piece(a) : piece(b);
  const Pose2 T_new_old = b_moves ? pose(a) * T_a_b * Inverse(pose(b)) : pose(b) * Inverse(T_a_b) * Inverse(pose(a));
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (pieces_[i] != moving) continue;
    const auto& [map, number] = trajectories_[i];
    for (Pose2& at : maps_[static_cast<std::size_t>(map)].poses[static_cast<std::size_t>(number)]) at = T_new_old * at;
    pieces_[i] = staying;
  }
  ++num_layouts_;
}

std::set<int> FleetGraph::MapsOf(int piece) const {
  std::set<int> maps;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (pieces_[i] == piece) maps.insert(trajectories_[i].first);
  }
  return maps;
}

void FleetGraph::Solve() {
  if (!needs_solving_) return;
  const std::set<int> pieces(pieces_.begin(), pieces_.end());
  for (const int piece : pieces) {
    const std::set<int> maps = MapsOf(piece);
    maps.size() == 1 ? TakeOwnPoses(piece) : SolveTogether(piece, maps);
  }
  needs_solving_ = false;
  ++num_layouts_;
}

void FleetGraph::TakeOwnPoses(int piece) {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (pieces_[i] != piece) continue;
    const auto& [number, trajectory] = trajectories_[i];
    Map& map = maps_[static_cast<std::size_t>(number)];
    map.poses[static_cast<std::size_t>(trajectory)] = map.graph->poses()[static_cast<std::size_t>(trajectory)];
    if (map.graph->newest()->trajectory == trajectory) map.covariance = {};
  }
}

/// Of all that its maps know. Where that rejects loops, once more without them.
void FleetGraph::SolveTogether(int piece, const std::set<int>& maps) {
  std::vector<int> first_pose(maps_.size(), -1);
  PoseGraph graph = MakePoseGraph(maps, first_pose);
  graph.Optimise();
  if (RejectContradicted(graph, first_pose)) {
    FindPieces();
    const std::set<int> left = MapsOf(piece);
    return left.size() == 1 ? TakeOwnPoses(piece) : SolveTogether(piece, left);
  }
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (pieces_[i] != piece) continue;
    const auto& [number, trajectory] = trajectories_[i];
    const int first = IndexOf({number, {trajectory, 0}}, map(number), first_pose);
    std::vector<Pose2>& poses = maps_[static_cast<std::size_t>(number)].poses[static_cast<std::size_t>(trajectory)];
    std::copy_n(graph.poses().begin() + first, poses.size(), poses.begin());
  }
  EstimateCovariances(graph, piece, first_pose);
}

/// Of whole maps. first_pose: gets where each of them begins.
PoseGraph FleetGraph::MakePoseGraph(const std::set<int>& maps, std::vector<int>& first_pose) const {
  PoseGraph graph(constants_.graph.edges.optimisation);
  int first_before = -1;
  for (const int number : maps) {
    const Map& map = maps_[static_cast<std::size_t>(number)];
    const int first = first_pose[static_cast<std::size_t>(number)] = static_cast<int>(graph.poses().size());
    for (const std::vector<Pose2>& trajectory : map.poses) {
      for (const Pose2& pose : trajectory) graph.AddPose(pose);
    }
    const PoseGraph own = map.graph->MakePoseGraph();
    for (GraphEdge edge : own.edges()) {
      edge.from += first;
      edge.to += first;
      graph.AddEdge(edge);
    }
    if (first_before >= 0) {  // holds what loops hold together loosely from drifting away
      const Pose2 motion = Inverse(graph.poses()[static_cast<std::size_t>(first_before)]) *
                           graph.poses()[static_cast<std::size_t>(first)];
      graph.AddEdge(GraphEdge::Make(first_before, first, motion, constants_.graph.edges.across_break));
    }
    first_before = first;
  }
  for (const FleetLoop& loop : loops_) {
    if (maps.contains(loop.older.map) && maps.contains(loop.newer.map)) graph.AddEdge(MakeEdge(loop, first_pose));
  }
  return graph;
}

KnownMotions FleetGraph::CollectMotions(int piece) const {
  KnownMotions motions;
  std::vector<std::vector<int>> first_poses(maps_.size());  // by map and trajectory
  for (const int number : MapsOf(piece)) {
    const Map& map = maps_[static_cast<std::size_t>(number)];
    std::vector<bool> is_taken;
    for (const int trajectory : map.trajectories) {
      is_taken.push_back(pieces_[static_cast<std::size_t>(trajectory)] == piece);
    }
    first_poses[static_cast<std::size_t>(number)] =
        motions.Add(*map.graph, map.poses, is_taken, constants_.graph.edges);
  }
  const auto Index = [&](const FleetKeyframeId& at) {
    return first_poses[static_cast<std::size_t>(at.map)][static_cast<std::size_t>(at.id.trajectory)] + at.id.number;
  };
  for (const auto& [older, newer, T_older_newer] : loops_) {
    if (this->piece(older) != piece) continue;
    const Loop loop{older.id, newer.id, T_older_newer};
    motions.edges.push_back({Index(older), Index(newer), crsm::MakeEdge(loop, constants_.graph.edges)});
  }
  return motions;
}

/// How well the newest keyframe of each map of a piece is known, as seen from the first of all.
void FleetGraph::EstimateCovariances(const PoseGraph& solved, int piece, const std::vector<int>& first_pose) {
  std::vector<std::pair<Map*, std::size_t>> asked;  // and the index of its newest keyframe
  for (int number = 0; number < num_maps(); ++number) {
    if (first_pose[static_cast<std::size_t>(number)] < 0 || this->piece(newest(number)) != piece) continue;
    Map& map = maps_[static_cast<std::size_t>(number)];
    map.covariance = {};
    asked.emplace_back(&map, IndexOf(newest(number), *map.graph, first_pose));
  }
  const double share = 1.0 / constants_.samples;
  solved.Sample(constants_.samples, 1, [&](const std::vector<Pose2>& sample) {
    for (const auto& [map, index] : asked) {
      const double x = sample[index].x_m - solved.poses()[index].x_m;
      const double y = sample[index].y_m - solved.poses()[index].y_m;
      const double yaw = WrapAngle(sample[index].yaw_rad - solved.poses()[index].yaw_rad);
      const PoseCovariance products{x * x, x * y, x * yaw, y * y, y * yaw, yaw * yaw};
      for (std::size_t k = 0; k < products.size(); ++k) map->covariance[k] += share * products[k];
    }
  });
}

GraphEdge FleetGraph::MakeEdge(const FleetLoop& loop, const std::vector<int>& first_pose) const {
  const auto Index = [&](const FleetKeyframeId& at) { return IndexOf(at, map(at.map), first_pose); };
  return ToGraphEdge(crsm::MakeEdge({loop.older.id, loop.newer.id, loop.T_older_newer}, constants_.graph.edges),
                     Index(loop.older), Index(loop.newer));
}

/// Whether any was.
bool FleetGraph::RejectContradicted(const PoseGraph& solved, const std::vector<int>& first_pose) {
  const auto IsSolved = [&](const FleetKeyframeId& at) { return first_pose[static_cast<std::size_t>(at.map)] >= 0; };
  const std::size_t num_before = loops_.size();
  std::erase_if(loops_, [&](const FleetLoop& loop) {
    const bool contradicted = IsSolved(loop.older) && IsSolved(loop.newer) &&
                              solved.SquaredError(MakeEdge(loop, first_pose)) > constants_.graph.edges.contradicted;
    if (contradicted) rejected_.push_back(loop);
    return contradicted;
  });
  return loops_.size() < num_before;
}

Pose2 FleetGraph::FindFrame(int map) const {
  const FleetKeyframeId newest = this->newest(map);
  return pose(newest) * Inverse(this->map(map).pose(newest.id));
}

}  // namespace crsm
