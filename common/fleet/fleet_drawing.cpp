#include "common/fleet/fleet_drawing.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/match/judge/census.hpp"
#include "common/math/interpolate.hpp"
#include "common/scan/hits.hpp"

namespace crsm {

void FleetClock::Add(const FleetKeyframeId& keyframe, std::int64_t utime, std::int64_t heard_utime) {
  const auto index = static_cast<std::size_t>(keyframe.map);
  if (index >= maps_.size()) maps_.resize(index + 1);
  Map& map = maps_[index];
  map.keyframes[utime] = keyframe.id;
  const std::int64_t offset = heard_utime - utime;
  map.offset = std::min(map.offset.value_or(offset), offset);
}

std::int64_t FleetClock::TimeOf(int map, std::int64_t utime) const {
  return utime + maps_[static_cast<std::size_t>(map)].offset.value_or(0);
}

std::optional<Pose2> FleetClock::FindPose(const FleetGraph& fleet, int map, std::int64_t time, int piece,
                                          const FleetConstants& constants) const {
  if (static_cast<std::size_t>(map) >= maps_.size()) return std::nullopt;
  const auto& [keyframes, offset] = maps_[static_cast<std::size_t>(map)];
  if (!offset) return std::nullopt;
  const std::int64_t utime = time - *offset;
  const auto next = keyframes.upper_bound(utime);
  if (next == keyframes.begin()) return std::nullopt;
  const auto& [before_utime, before] = *std::prev(next);
  if (fleet.piece({map, before}) != piece) return std::nullopt;
  const Pose2& pose = fleet.pose({map, before});
  const bool goes_on = next != keyframes.end() && next->second.trajectory == before.trajectory;
  if (!goes_on) {
    const double since_s = 1e-6 * static_cast<double>(utime - before_utime);
    return since_s <= constants.robot_stays_s ? std::optional(pose) : std::nullopt;
  }
  const double share = static_cast<double>(utime - before_utime) / static_cast<double>(next->first - before_utime);
  return Interpolate(pose, fleet.pose({map, next->second}), share);
}

bool FleetDrawing::Draw(const Fleet& fleet, const FleetClock& clock, int piece, std::int64_t version, int most) {
  if (num_looked_at_ == 0) {
    map_ = MapUpdater(rules_);
    bytes_version_ = -1;
  }
  map_.SkipTo(std::max(version, map_.version()));
  const std::vector<FleetKeyframeId>& keyframes = fleet.keyframes();
  for (; num_looked_at_ < keyframes.size() && most > 0; ++num_looked_at_) {
    const FleetKeyframeId& at = keyframes[num_looked_at_];
    if (fleet.graph().piece(at) != piece) continue;
    map_.DrawMore({PackedRays(WithoutRobots(fleet, clock, at)), fleet.graph().pose(at)});
    --most;
  }
  return num_looked_at_ == keyframes.size();
}

ValidRays FleetDrawing::WithoutRobots(const Fleet& fleet, const FleetClock& clock,
                                      const FleetKeyframeId& keyframe) const {
  const FleetGraph& graph = fleet.graph();
  const Keyframe& scan = graph.map(keyframe.map).keyframe(keyframe.id);
  const std::int64_t time = clock.TimeOf(keyframe.map, scan.utime);
  const Pose2 T_laser_map = Inverse(graph.pose(keyframe));
  std::vector<Pose2> others;  // in the frame of the laser
  for (int map = 0; map < fleet.num_maps(); ++map) {
    if (map == keyframe.map) continue;
    const auto pose = clock.FindPose(graph, map, time, graph.piece(keyframe), constants_);
    if (pose) others.push_back(T_laser_map * *pose);
  }
  ValidRays rays = scan.rays.Unpack();
  if (others.empty()) return rays;
  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  ValidRays kept;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Pose2 hit{hits_m(0, static_cast<Eigen::Index>(i)), hits_m(1, static_cast<Eigen::Index>(i)), 0.0};
    const bool is_robot =
        std::ranges::any_of(others, [&](const Pose2& robot) { return Distance(robot, hit) < constants_.robot_m; });
    if (is_robot) continue;
    kept.angle_rad.push_back(rays.angle_rad[i]);
    kept.range_m.push_back(rays.range_m[i]);
  }
  return kept;
}

double FleetDrawing::ComputeAgreement(const Fleet& fleet, const FleetKeyframeId& keyframe) {
  if (bytes_version_ != map_.version()) {
    if (bytes_version_ < 0) bytes_.emplace(map_.geometry().cell_size_m());
    map_.CopyTo(*bytes_, bytes_version_);
    bytes_version_ = map_.version();
  }
  const Eigen::Matrix2Xd hits_m = ComputeHits(fleet.graph().map(keyframe.map).keyframe(keyframe.id).rays.Unpack());
  return CountRays(*bytes_, hits_m, fleet.graph().pose(keyframe), constants_.match.census).fits;
}

std::vector<int> SortPieces(const FleetGraph& fleet) {
  std::map<int, int> sizes;  // by piece
  const auto& trajectories = fleet.trajectories();
  for (std::size_t i = 0; i < trajectories.size(); ++i) {
    const auto& [map, number] = trajectories[i];
    sizes[fleet.pieces()[i]] += fleet.map(map).size(number);
  }
  std::vector<int> sorted;
  for (const auto& [piece, size] : sizes) sorted.push_back(piece);
  std::ranges::stable_sort(sorted, [&](int a, int b) { return sizes.at(a) > sizes.at(b); });
  return sorted;
}

MapPieces DescribePieces(const Fleet& fleet, const std::vector<int>& pieces) {
  const FleetGraph& graph = fleet.graph();
  const auto NumberOf = [&](std::size_t trajectory) {
    return static_cast<int>(std::ranges::find(pieces, graph.pieces()[trajectory]) - pieces.begin()) + 1;
  };
  std::map<FleetKeyframeId, std::int64_t> first_scans;  // where each trajectory begins, in the order of all
  for (std::size_t i = 0; i < fleet.keyframes().size(); ++i) {
    if (fleet.keyframes()[i].id.number == 0) first_scans[fleet.keyframes()[i]] = static_cast<std::int64_t>(i);
  }
  MapPieces found;
  std::vector<MapPiece> all(pieces.size());
  const auto& trajectories = graph.trajectories();
  for (std::size_t i = 0; i < trajectories.size(); ++i) {
    const auto& [map, number] = trajectories[i];
    const KeyframeGraph& own = graph.map(map);
    MapPiece& piece = all[static_cast<std::size_t>(NumberOf(i)) - 1];
    piece.keyframes += own.size(number);
    piece.scans += own.size(number);
    piece.way_m += own.path_m(own.LastOf(number));
    if (i == 0) continue;
    const auto& [map_before, number_before] = trajectories[i - 1];
    Break at;
    at.utime = own.keyframe({number, 0}).utime;
    at.scan = first_scans.at({map, {number, 0}});
    at.reason = BreakReason::kSession;
    at.T_map_before = graph.pose({map_before, graph.map(map_before).LastOf(number_before)});
    at.piece_before = NumberOf(i - 1);
    at.piece = NumberOf(i);
    found.breaks.push_back(at);
  }
  for (int map = 0; map < graph.num_maps(); ++map) {
    found.num_closed += std::ssize(graph.map(map).loops());
    found.num_rejected += graph.map(map).num_loops_dropped();
  }
  found.num_closed += std::ssize(graph.loops());
  found.num_rejected += std::ssize(graph.rejected());
  found.num_keyframes = found.num_matched = std::ssize(fleet.keyframes());
  found.num_pieces = std::ssize(all);
  found.num_breaks = std::ssize(found.breaks);
  all.resize(std::min(all.size(), MapPieces::kMostPieces));
  found.pieces = std::move(all);
  if (found.breaks.size() > MapPieces::kMostBreaks) {
    found.breaks.erase(found.breaks.begin(), found.breaks.end() - static_cast<std::ptrdiff_t>(MapPieces::kMostBreaks));
  }
  return found;
}

std::vector<PlacedLoop> PlaceLoops(const FleetGraph& fleet, int piece) {
  std::vector<PlacedLoop> placed;
  std::map<int, int> joined;  // of each trajectory that with which it was joined first
  const auto RootOf = [&](int trajectory) {
    while (joined.contains(trajectory)) trajectory = joined.at(trajectory);
    return trajectory;
  };
  const auto Place = [&](const std::vector<FleetLoop>& loops, bool rejected) {
    std::vector<PlacedLoop> all;
    for (const FleetLoop& loop : loops) {
      const int older = RootOf(fleet.TrajectoryOf(loop.older));
      const int newer = RootOf(fleet.TrajectoryOf(loop.newer));
      const bool joins = !rejected && older != newer;
      if (joins) joined[std::max(older, newer)] = std::min(older, newer);
      if (fleet.piece(loop.older) != piece || fleet.piece(loop.newer) != piece) continue;
      all.push_back({fleet.pose(loop.older), fleet.pose(loop.newer), rejected, joins});
    }
    const std::size_t num = std::min(all.size(), kMostPlacedLoops / 2);
    placed.insert(placed.end(), all.end() - static_cast<std::ptrdiff_t>(num), all.end());
  };
  Place(fleet.loops(), false);
  Place(fleet.rejected(), true);
  return placed;
}

}  // namespace crsm
