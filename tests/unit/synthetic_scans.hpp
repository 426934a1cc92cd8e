#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "common/map/byte_map.hpp"
#include "common/map/map_updater.hpp"
#include "common/map/paper_drawing.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "common/parameters.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/ray_selector.hpp"
#include "common/scan/scan_match.hpp"
#include "common/worlds/world.hpp"

namespace crsm {

// A room without doors, seen from the inside, in the map frame. Its sides run through the middle of cells of 0.05 m.
inline constexpr double kRoomLeftM = -3.025;
inline constexpr double kRoomRightM = 4.025;
inline constexpr double kRoomBottomM = -2.025;
inline constexpr double kRoomTopM = 3.025;

/// How far it is from a point in the room to its wall: the nearest of the lines through its four sides.
inline double RangeInRoom(double x_m, double y_m, double angle_rad) {
  const double dx = std::cos(angle_rad);
  const double dy = std::sin(angle_rad);
  double range_m = std::numeric_limits<double>::infinity();
  if (dx > 1e-12) range_m = std::min(range_m, (kRoomRightM - x_m) / dx);
  if (dx < -1e-12) range_m = std::min(range_m, (kRoomLeftM - x_m) / dx);
  if (dy > 1e-12) range_m = std::min(range_m, (kRoomTopM - y_m) / dy);
  if (dy < -1e-12) range_m = std::min(range_m, (kRoomBottomM - y_m) / dy);
  return range_m;
}

/// All round from a place, without noise; `range` tells how far it is from (x_m, y_m) at an angle of the map frame.
template <class Range>
LaserScan ScanAllRound(Range&& range, const Pose2& T_map_laser, std::int64_t utime, int num_beams) {
  LaserScan scan{utime, static_cast<float>(-kPi), static_cast<float>(2.0 * kPi / num_beams), {}};
  for (int beam = 0; beam < num_beams; ++beam) {
    const double angle_rad = scan.angle_min_rad + static_cast<float>(beam) * scan.angle_step_rad;
    scan.ranges_m.push_back(
        static_cast<float>(range(T_map_laser.x_m, T_map_laser.y_m, T_map_laser.yaw_rad + angle_rad)));
  }
  return scan;
}

inline LaserScan ScanRoom(const Pose2& T_map_laser, std::int64_t utime = 1, int num_beams = 360) {
  return ScanAllRound(RangeInRoom, T_map_laser, utime, num_beams);
}

/// The map of the room in cells of 0.05 m, as perfect as it can be.
inline std::uint8_t RoomByte(Cell cell) {
  constexpr Cell kLow{-61, -41};
  constexpr Cell kHigh{80, 60};
  if (cell.x < kLow.x || cell.x > kHigh.x || cell.y < kLow.y || cell.y > kHigh.y) return kUnexploredByte;
  const bool on_wall = cell.x == kLow.x || cell.x == kHigh.x || cell.y == kLow.y || cell.y == kHigh.y;
  return on_wall ? kOccupiedByte : kFreeByte;
}

// The same room with its upper right corner cut off by a block: no place in it is like another.
inline constexpr double kBlockLeftM = 2.025;
inline constexpr double kBlockBottomM = 1.025;

/// As RangeInRoom: the nearest of the room's sides and of the block's two.
inline double RangeInNiche(double x_m, double y_m, double angle_rad) {
  const double dx = std::cos(angle_rad);
  const double dy = std::sin(angle_rad);
  double range_m = RangeInRoom(x_m, y_m, angle_rad);
  const double to_left_m = (kBlockLeftM - x_m) / dx;
  const double to_bottom_m = (kBlockBottomM - y_m) / dy;
  if (dx > 1e-12 && to_left_m > 0 && y_m + to_left_m * dy >= kBlockBottomM) range_m = std::min(range_m, to_left_m);
  if (dy > 1e-12 && to_bottom_m > 0 && x_m + to_bottom_m * dx >= kBlockLeftM) range_m = std::min(range_m, to_bottom_m);
  return range_m;
}

inline LaserScan ScanNiche(const Pose2& T_map_laser, std::int64_t utime = 1, int num_beams = 360) {
  return ScanAllRound(RangeInNiche, T_map_laser, utime, num_beams);
}

inline std::uint8_t NicheByte(Cell cell) {
  constexpr Cell kBlock{40, 20};
  if (cell.x > kBlock.x && cell.y > kBlock.y) return kUnexploredByte;
  const bool on_block = (cell.x == kBlock.x && cell.y >= kBlock.y) || (cell.y == kBlock.y && cell.x >= kBlock.x);
  return on_block && RoomByte(cell) != kUnexploredByte ? kOccupiedByte : RoomByte(cell);
}

inline ScanMatch MatchedAt(std::int64_t utime, const Pose2& pose) {
  return {utime, pose, 1.0, 1, 1, 0, MatchState::kOk};
}

/// Tiles from (low, low) to (high, high), each cell as `paint` says.
template <class Paint>
std::vector<TileChange> PaintTiles(int low, int high, Paint&& paint) {
  TileBytes unexplored;
  unexplored.fill(kUnexploredByte);
  std::vector<TileChange> changes;
  for (int y = low; y <= high; ++y) {
    for (int x = low; x <= high; ++x) {
      TileBytes cells;
      for (int i = 0; i < kTileCells; ++i) {
        cells[static_cast<std::size_t>(i)] = paint(CellAt({x, y}, i));
      }
      changes.push_back({{x, y}, PackRuns(unexplored, cells)});
    }
  }
  return changes;
}

/// A scan's measurements, all of them critical.
inline CriticalRays AllRays(const LaserScan& scan, const ScanParameters& parameters) {
  CriticalRays rays{scan.utime, FindValidRays(scan, parameters), {}};
  for (std::size_t i = 0; i < rays.rays.size(); ++i) rays.critical.push_back(static_cast<int>(i));
  return rays;
}

/// The parameters that ship, but for a laser of 20 m, and every scan is drawn.
inline Parameters TestParameters() {
  return {.scan = {.range_max_m = 20.0}, .update = {.update_distance_m = 0.0, .update_angle_rad = 0.0}};
}

/// A map into which scans are drawn as in the paper, with an intensity of 0.1 whatever the scan: easy to reckon.
inline MapUpdater PlainUpdater(const UpdateParameters& parameters = TestParameters().update,
                               const PaperDrawingConstants& constants = {.intensity_min = 0.1, .intensity_max = 0.1}) {
  return {parameters, std::make_unique<PaperDrawing>(constants)};
}

/// With those parameters.
inline CriticalRays AllRays(const LaserScan& scan) { return AllRays(scan, TestParameters().scan); }

/// The critical rays of a scan, as a selector picks them with those parameters.
inline CriticalRays RaysOf(const LaserScan& scan) { return RaySelector(TestParameters()).Select(scan); }

/// A map with cells of that size, from (low, low) to (high, high) as `paint` says.
template <class Paint>
ByteMap PaintMap(int low, int high, Paint&& paint, double cell_size_m = 0.05) {
  ByteMap map(cell_size_m);
  for (const TileChange& change : PaintTiles(low, high, paint)) map.Apply(change);
  return map;
}

/// What a matcher remembers after these matches. A map that began with the first of them is one that grows.
inline TrackingState After(const std::vector<ScanMatch>& matches) {
  const bool grows = !matches.empty() && matches.front().state == MatchState::kFirst;
  TrackingState state = grows ? TrackingState() : TrackingState::OnFinishedMap();
  for (const ScanMatch& match : matches) state.Add(match);
  return state;
}

/// The critical rays of a scan, as a selector picks them with the parameters that ship.
inline CriticalRays ShippedRays(const LaserScan& scan) { return RaySelector(Parameters{}).Select(scan); }

/// All round from a place among walls; nothing is seen beyond 8 m.
inline LaserScan ScanWalls(const std::vector<Wall>& walls, const Pose2& T_map_laser, std::int64_t utime) {
  const auto Range = [&](double x_m, double y_m, double angle_rad) {
    const double range_m = CastRay(walls, {x_m, y_m}, ComputeSinCos(angle_rad));
    return range_m < 8.0 ? range_m : 0.0;
  };
  return ScanAllRound(Range, T_map_laser, utime, 360);
}

/// On a map that grows, after eleven scans that were matched at one place with that fitness, and some that were lost.
inline TrackingState AfterStanding(const Pose2& T_map_laser, double fitness, int num_lost = 0,
                                   const std::optional<Pose2>& T_odom_robot = {}) {
  std::vector<ScanMatch> matches;
  for (int k = 0; k < 12 + num_lost; ++k) {
    const MatchState state = k == 0 ? MatchState::kFirst : k < 12 ? MatchState::kOk : MatchState::kLost;
    matches.push_back({k, T_map_laser, fitness, 1, 1, 0, state, 0, {}, {}, T_odom_robot});
  }
  return After(matches);
}

}  // namespace crsm
