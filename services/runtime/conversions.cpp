#include "services/runtime/conversions.hpp"

#include <algorithm>
#include <array>

namespace crsm {

LaserScan FromMessage(const bot_core::planar_lidar_t& message) {
  return {message.utime, message.rad0, message.radstep, message.ranges};
}

bot_core::planar_lidar_t ToMessage(const LaserScan& scan) {
  bot_core::planar_lidar_t message;
  message.utime = scan.utime;
  message.nranges = static_cast<std::int32_t>(scan.ranges_m.size());
  message.ranges = scan.ranges_m;
  message.nintensities = 0;
  message.rad0 = scan.angle_min_rad;
  message.radstep = scan.angle_step_rad;
  return message;
}

ScanMatch FromMessage(const scan_match_t& message) {
  return {message.utime,
          {message.x_m, message.y_m, message.yaw_rad},
          message.fitness,
          message.evaluations,
          message.num_critical,
          message.map_version,
          static_cast<MatchState>(message.state),
          message.best_evaluation,
          std::to_array(message.covariance),
          std::to_array(message.degenerate_axis)};
}

scan_match_t ToMessage(const ScanMatch& match) {
  scan_match_t message;
  message.utime = match.utime;
  message.x_m = match.T_map_laser.x_m;
  message.y_m = match.T_map_laser.y_m;
  message.yaw_rad = match.T_map_laser.yaw_rad;
  message.fitness = match.fitness;
  message.evaluations = match.evaluations;
  message.best_evaluation = match.best_evaluation;
  message.num_critical = match.num_critical;
  message.map_version = match.map_version;
  std::copy(match.covariance.begin(), match.covariance.end(), message.covariance);
  std::copy(match.degenerate_axis.begin(), match.degenerate_axis.end(), message.degenerate_axis);
  message.state = static_cast<std::int8_t>(match.state);
  return message;
}

TileChange FromMessage(const map_tile_t& message) { return {{message.tile_x, message.tile_y}, message.runs}; }

map_tile_t ToMessage(const TileChange& change) {
  map_tile_t message;
  message.tile_x = static_cast<std::int16_t>(change.index.x);
  message.tile_y = static_cast<std::int16_t>(change.index.y);
  message.num_bytes = static_cast<std::int32_t>(change.runs.size());
  message.runs = change.runs;
  return message;
}

CriticalRays FromMessage(const critical_rays_t& message) {
  return {message.utime,
          {message.angle_rad, message.range_m},
          std::vector<int>(message.critical.begin(), message.critical.end())};
}

critical_rays_t ToMessage(std::int64_t utime, const ValidRays& rays, const RaySelection& selection) {
  critical_rays_t message;
  message.utime = utime;
  message.num_rays = static_cast<std::int32_t>(rays.size());
  message.angle_rad = rays.angle_rad;
  message.range_m = rays.range_m;
  message.num_critical = static_cast<std::int32_t>(selection.critical.size());
  message.critical.assign(selection.critical.begin(), selection.critical.end());
  message.density_scale = selection.density_scale;
  message.mean_sparseness_m = ComputeMeanSparseness(rays);
  return message;
}

bot_core::pose_t ToPoseMessage(std::int64_t utime, const Pose2& T_map_laser) {
  const auto half = ComputeSinCos(0.5 * T_map_laser.yaw_rad);
  return {utime, {T_map_laser.x_m, T_map_laser.y_m, 0.0}, {}, {half.cos, 0.0, 0.0, half.sin}, {}, {}};
}

bot_core::pose_t ToPoseMessage(const ScanMatch& match) { return ToPoseMessage(match.utime, match.T_map_laser); }

}  // namespace crsm
