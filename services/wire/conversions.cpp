#include "services/wire/conversions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <tuple>

#include "common/logs/crc32.hpp"

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

LaserScan FromMessage(const sweep_t& message) {
  return {message.utime, message.angle_min_rad, message.angle_step_rad, message.range_m, message.time_s};
}

sweep_t ToSweepMessage(const LaserScan& scan) {
  const auto num_beams = static_cast<std::int32_t>(scan.ranges_m.size());
  return {scan.utime, num_beams, scan.ranges_m, scan.times_s, scan.angle_min_rad, scan.angle_step_rad};
}

std::optional<WheelMotion> FromMessages(const std::vector<wheel_motion_t>& messages) {
  if (messages.empty()) return std::nullopt;
  const wheel_motion_t& message = messages.front();
  return WheelMotion{FromMessage(message.T_from_to), message.sigma_m, message.sigma_rad};
}

std::vector<wheel_motion_t> ToMessages(const std::optional<WheelMotion>& motion) {
  if (!motion) return {};
  return {{ToMessage(motion->T_from_to), motion->sigma_m, motion->sigma_rad}};
}

WheelModel::State FromMessage(const wheel_model_t& message) {
  return {std::to_array(message.way_information),
          std::to_array(message.way_vector),
          std::to_array(message.turn),
          std::to_array(message.way_noise),
          std::to_array(message.turn_noise),
          message.wheels_error_m,
          message.velocity_error_m,
          message.steps,
          message.slips,
          message.steps_since_slip,
          message.have_moved == 1,
          message.has_start == 1,
          FromMessage(message.T_map_start),
          FromMessage(message.T_odom_start)};
}

wheel_model_t ToMessage(const WheelModel::State& state) {
  wheel_model_t message;
  std::ranges::copy(state.way_information, message.way_information);
  std::ranges::copy(state.way_vector, message.way_vector);
  std::ranges::copy(state.turn, message.turn);
  std::ranges::copy(state.way_noise, message.way_noise);
  std::ranges::copy(state.turn_noise, message.turn_noise);
  message.wheels_error_m = state.wheels_error_m;
  message.velocity_error_m = state.velocity_error_m;
  message.steps = state.steps;
  message.slips = state.slips;
  message.steps_since_slip = state.steps_since_slip;
  message.have_moved = state.have_moved ? 1 : 0;
  message.has_start = state.has_start ? 1 : 0;
  message.T_map_start = ToMessage(state.T_map_start);
  message.T_odom_start = ToMessage(state.T_odom_start);
  return message;
}

ScanMatch FromMessage(const scan_match_t& message) {
  const Pose2 T_odom_robot{message.odometry_x_m, message.odometry_y_m, message.odometry_yaw_rad};
  return {message.utime,
          {message.x_m, message.y_m, message.yaw_rad},
          message.fitness,
          message.evaluations,
          message.num_critical,
          message.map_version,
          static_cast<MatchState>(message.state),
          message.best_evaluation,
          std::to_array(message.covariance),
          std::to_array(message.degenerate_axis),
          message.has_odometry ? std::optional(T_odom_robot) : std::nullopt,
          {message.twist_x_m_s, message.twist_y_m_s, message.twist_yaw_rad_s},
          message.trajectory,
          message.floating == 1,
          FromMessages(message.by_wheels)};
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
  message.twist_x_m_s = match.twist.x_m_s;
  message.twist_y_m_s = match.twist.y_m_s;
  message.twist_yaw_rad_s = match.twist.yaw_rad_s;
  message.has_odometry = match.T_odom_robot ? 1 : 0;
  const Pose2 T_odom_robot = match.T_odom_robot.value_or(Pose2{});
  message.odometry_x_m = T_odom_robot.x_m;
  message.odometry_y_m = T_odom_robot.y_m;
  message.odometry_yaw_rad = T_odom_robot.yaw_rad;
  message.trajectory = match.trajectory;
  message.floating = match.floating ? 1 : 0;
  message.by_wheels = ToMessages(match.by_wheels);
  message.num_by_wheels = static_cast<std::int32_t>(message.by_wheels.size());
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

Pose2 FromMessage(const pose2_t& message) { return {message.x_m, message.y_m, message.yaw_rad}; }

PlacedLoop FromMessage(const map_loop_t& message) {
  return {FromMessage(message.T_map_older), FromMessage(message.T_map_newer), message.rejected == 1,
          message.joins == 1};
}

map_loop_t ToMessage(const PlacedLoop& loop) {
  return {ToMessage(loop.T_map_older), ToMessage(loop.T_map_newer), static_cast<std::int8_t>(loop.rejected ? 1 : 0),
          static_cast<std::int8_t>(loop.joins ? 1 : 0)};
}

std::vector<MapChange> FromMessage(const changes_t& message) {
  std::vector<MapChange> changes;
  for (const change_t& change : message.changes) {
    changes.push_back({static_cast<ChangeKind>(change.kind),
                       {change.middle_m[0], change.middle_m[1]},
                       change.length_m,
                       change.width_m,
                       change.yaw_rad,
                       change.first_utime,
                       change.num_places});
  }
  return changes;
}

changes_t ToMessage(const std::vector<MapChange>& changes, std::int64_t utime, std::int64_t epoch) {
  changes_t message{utime, epoch, static_cast<std::int32_t>(changes.size()), {}};
  for (const MapChange& change : changes) {
    message.changes.push_back({static_cast<std::int8_t>(change.kind),
                               {change.middle.x_m, change.middle.y_m},
                               change.length_m,
                               change.width_m,
                               change.yaw_rad,
                               change.first_utime,
                               change.num_places});
  }
  return message;
}

MapPieces FromMessage(const map_pieces_t& message) {
  MapPieces pieces;
  pieces.num_pieces = message.num_all_pieces;
  pieces.num_breaks = message.num_all_breaks;
  pieces.num_matched = message.num_matched;
  pieces.num_bridged = message.num_bridged;
  pieces.num_keyframes = message.num_keyframes;
  pieces.num_closed = message.num_closed;
  pieces.num_rejected = message.num_rejected;
  if (message.off_m >= 0.0) {
    MapError& error = pieces.error.emplace();
    error.most_m = message.off_m;
    error.at = {message.off_at_m[0], message.off_at_m[1]};
    for (const map_doubt_t& doubt : message.doubts) error.doubts.push_back({{doubt.x_m, doubt.y_m}, doubt.off_m});
    const auto& [from, to] = std::tie(message.way_back_from, message.way_back_to);
    if (message.way_back_m >= 0.0) error.way_back = WayBack{{from[0], from[1]}, {to[0], to[1]}, message.way_back_m};
  }
  if (message.slip_m >= 0.0) pieces.slip = Slip{{message.slip_at_m[0], message.slip_at_m[1]}, message.slip_m};
  for (const map_piece_t& piece : message.pieces) pieces.pieces.push_back({piece.keyframes, piece.scans, piece.way_m});
  for (const map_break_t& at : message.breaks) {
    pieces.breaks.push_back({at.utime, at.scan, static_cast<BreakReason>(at.reason), at.seconds,
                             FromMessage(at.T_map_before), at.piece_before, at.piece});
  }
  return pieces;
}

map_pieces_t ToMessage(const MapPieces& pieces) {
  map_pieces_t message{};
  message.num_all_pieces = pieces.num_pieces;
  message.num_all_breaks = pieces.num_breaks;
  message.num_matched = pieces.num_matched;
  message.num_bridged = pieces.num_bridged;
  message.num_keyframes = pieces.num_keyframes;
  message.num_closed = pieces.num_closed;
  message.num_rejected = pieces.num_rejected;
  message.off_m = message.way_back_m = message.slip_m = -1.0;
  const auto Copy = [](const Point& point, double(&to)[2]) { to[0] = point.x_m, to[1] = point.y_m; };
  if (const auto& error = pieces.error) {
    message.off_m = error->most_m;
    Copy(error->at, message.off_at_m);
    for (const Doubt& doubt : error->doubts) message.doubts.push_back({doubt.at.x_m, doubt.at.y_m, doubt.off_m});
    message.num_doubts = static_cast<std::int32_t>(message.doubts.size());
    if (error->way_back) {
      Copy(error->way_back->from, message.way_back_from);
      Copy(error->way_back->to, message.way_back_to);
      message.way_back_m = error->way_back->then_m;
    }
  }
  if (pieces.slip) {
    message.slip_m = pieces.slip->off_m;
    Copy(pieces.slip->at, message.slip_at_m);
  }
  message.num_pieces = static_cast<std::int32_t>(pieces.pieces.size());
  for (const MapPiece& piece : pieces.pieces) message.pieces.push_back({piece.keyframes, piece.scans, piece.way_m});
  message.num_breaks = static_cast<std::int32_t>(pieces.breaks.size());
  for (const Break& at : pieces.breaks) {
    message.breaks.push_back({at.utime, at.scan, at.seconds, ToMessage(at.T_map_before), at.piece_before, at.piece,
                              static_cast<std::int8_t>(at.reason)});
  }
  return message;
}

namespace {

template <class Message>
std::vector<Point> PointsOf(const Message& message) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < message.x_m.size(); ++i) points.push_back({message.x_m[i], message.y_m[i]});
  return points;
}

template <class Message>
void SetPoints(const std::vector<Point>& points, Message& message) {
  message.num_points = static_cast<std::int32_t>(points.size());
  for (const auto& [x_m, y_m] : points) {
    message.x_m.push_back(x_m);
    message.y_m.push_back(y_m);
  }
}

}  // namespace

Mark FromMessage(const mark_t& message) {
  return {message.utime,
          message.id,
          message.kind,
          message.name,
          static_cast<MarkAction>(message.action),
          message.in_map_frame == 1,
          message.radius_m,
          PointsOf(message)};
}

mark_t ToMessage(const Mark& mark) {
  mark_t message{};
  message.utime = mark.utime;
  message.id = mark.id;
  message.kind = mark.kind;
  message.name = mark.name;
  message.action = static_cast<std::int8_t>(mark.action);
  message.in_map_frame = mark.in_map_frame ? 1 : 0;
  message.radius_m = mark.radius_m;
  SetPoints(mark.points, message);
  return message;
}

FixedMark FromMessage(const kept_mark_t& message) {
  FixedMark fixed{FromMessage(message.mark), {}};
  for (const fixed_point_t& point : message.fixed) {
    const KeyframeId id{point.keyframe.trajectory, point.keyframe.number};
    fixed.points.push_back({id.trajectory < 0 ? std::nullopt : std::optional(id), {point.x_m, point.y_m}});
  }
  return fixed;
}

kept_mark_t ToMessage(const FixedMark& fixed) {
  kept_mark_t message{};
  message.mark = ToMessage(fixed.mark);
  message.num_fixed = static_cast<std::int32_t>(fixed.points.size());
  for (const auto& [keyframe, at] : fixed.points) {
    const KeyframeId id = keyframe.value_or(KeyframeId{-1, -1});
    message.fixed.push_back({{id.trajectory, id.number}, at.x_m, at.y_m});
  }
  return message;
}

std::vector<AnchoredMark> FromMessage(const robot_marks_t& message) {
  std::vector<AnchoredMark> marks;
  for (const robot_mark_t& one : message.marks) {
    AnchoredMark& mark = marks.emplace_back();
    mark.mark = {one.utime, one.id, one.kind, one.name, one.num_sightings, std::to_array(one.covariance), false, {}};
    for (const fixed_point_t& point : one.points) {
      mark.points.push_back({{point.keyframe.trajectory, point.keyframe.number}, {point.x_m, point.y_m}});
    }
  }
  return marks;
}

robot_marks_t ToMessage(const std::vector<AnchoredMark>& marks, std::int64_t epoch) {
  constexpr double kStepsPerMetre = 1e3;
  constexpr double kStepsPerSquareMetre = 1e9;  // of radii from 0.001 m on
  const auto Round = [](double value, double steps) { return std::round(value * steps) / steps; };
  robot_marks_t message{};
  message.num_marks = static_cast<std::int32_t>(marks.size());
  std::uint32_t crc = 0;
  for (const auto& [mark, points] : marks) {
    robot_mark_t one{};
    one.utime = mark.utime;
    one.id = mark.id;
    one.kind = mark.kind;
    one.name = mark.name;
    one.num_sightings = mark.num_sightings;
    for (std::size_t i = 0; i < mark.covariance.size(); ++i) {
      const double rounded = Round(mark.covariance[i], kStepsPerSquareMetre);
      one.covariance[i] = rounded != 0.0 ? rounded : i == 1 ? 0.0 : 1.0 / kStepsPerSquareMetre;
    }
    one.num_points = static_cast<std::int32_t>(points.size());
    for (const auto& [keyframe, at] : points) {
      one.points.push_back(
          {{keyframe.trajectory, keyframe.number}, Round(at.x_m, kStepsPerMetre), Round(at.y_m, kStepsPerMetre)});
    }
    std::string bytes(static_cast<std::size_t>(one.getEncodedSize()), '\0');
    one.encode(bytes.data(), 0, one.getEncodedSize());
    crc = Crc32(bytes, crc);
    message.marks.push_back(std::move(one));
  }
  message.epoch = epoch;
  message.checksum = marks.empty() ? 0 : std::max<std::int64_t>(1, crc);
  return message;
}

PlacedMark FromMessage(const placed_mark_t& message) {
  return {message.utime,         message.id,
          message.kind,          message.name,
          message.num_sightings, std::to_array(message.covariance),
          message.floating == 1, PointsOf(message)};
}

placed_mark_t ToMessage(const PlacedMark& mark) {
  placed_mark_t message{};
  message.utime = mark.utime;
  message.id = mark.id;
  message.kind = mark.kind;
  message.name = mark.name;
  message.num_sightings = mark.num_sightings;
  std::ranges::copy(mark.covariance, message.covariance);
  message.floating = mark.floating ? 1 : 0;
  SetPoints(mark.points, message);
  return message;
}

pose2_t ToMessage(const Pose2& pose) { return {pose.x_m, pose.y_m, pose.yaw_rad}; }

CriticalRays FromMessage(const critical_rays_t& message) {
  return {message.utime,
          {message.angle_rad, message.range_m, message.time_s},
          std::vector<int>(message.critical.begin(), message.critical.end())};
}

critical_rays_t ToMessage(const CriticalRays& scan) {
  critical_rays_t message;
  message.utime = scan.utime;
  message.num_rays = static_cast<std::int32_t>(scan.rays.size());
  message.angle_rad = scan.rays.angle_rad;
  message.range_m = scan.rays.range_m;
  message.num_times = static_cast<std::int32_t>(scan.rays.time_s.size());
  message.time_s = scan.rays.time_s;
  message.num_critical = static_cast<std::int32_t>(scan.critical.size());
  message.critical.assign(scan.critical.begin(), scan.critical.end());
  return message;
}

TrackingState FromMessage(const tracking_state_t& message) {
  TrackingState::Parts parts{message.num_scans,
                             message.num_lost,
                             message.newest_utime,
                             message.on_finished_map == 1,
                             message.fitness,
                             {},
                             FromMessage(message.T_local_map),
                             static_cast<Onset>(message.onset),
                             FromMessage(message.T_map_guess),
                             message.trajectory,
                             message.floating == 1,
                             WheelModel(FromMessage(message.wheels)),
                             message.motion_error_m};
  for (const scan_match_t& match : message.recent) parts.recent.push_back(FromMessage(match));
  return TrackingState(std::move(parts));
}

tracking_state_t ToMessage(const TrackingState& tracking) {
  tracking_state_t message;
  message.num_scans = tracking.num_scans();
  message.num_lost = tracking.num_lost();
  message.newest_utime = tracking.newest_utime();
  message.on_finished_map = tracking.on_finished_map() ? 1 : 0;
  message.fitness.assign(tracking.fitnesses().begin(), tracking.fitnesses().end());
  message.num_fitnesses = static_cast<std::int32_t>(message.fitness.size());
  for (const ScanMatch& match : tracking.recent()) message.recent.push_back(ToMessage(match));
  message.num_recent = static_cast<std::int32_t>(message.recent.size());
  message.T_local_map = ToMessage(tracking.T_local_map());
  message.onset = static_cast<std::int8_t>(tracking.onset());
  message.T_map_guess = ToMessage(tracking.T_map_guess());
  message.trajectory = tracking.trajectory();
  message.floating = tracking.floating() ? 1 : 0;
  message.wheels = ToMessage(tracking.wheels().state());
  message.motion_error_m = tracking.motion_error_m();
  return message;
}

bot_core::pose_t ToPoseMessage(std::int64_t utime, const Pose2& T_map_laser) {
  const auto half = ComputeSinCos(0.5 * T_map_laser.yaw_rad);
  return {utime, {T_map_laser.x_m, T_map_laser.y_m, 0.0}, {}, {half.cos, 0.0, 0.0, half.sin}, {}, {}};
}

Odometry FromMessage(const bot_core::pose_t& message) {
  const auto& [w, x, y, z] = message.orientation;
  const double square = w * w + x * x + y * y + z * z;
  if (square == 0.0) return {message.utime, std::nullopt};
  const double yaw_rad = std::atan2(2.0 * (w * z + x * y), square - 2.0 * (y * y + z * z));
  return {message.utime, RoundOdometry({message.pos[0], message.pos[1], yaw_rad})};
}

bot_core::pose_t ToMessage(const Odometry& odometry) {
  if (!odometry.T_odom_robot) return {odometry.utime, {}, {}, {}, {}, {}};
  return ToPoseMessage(odometry.utime, *odometry.T_odom_robot);
}

bot_core::pose_t ToPoseMessage(const ScanMatch& match) { return ToPoseMessage(match.utime, match.T_map_laser); }

}  // namespace crsm
