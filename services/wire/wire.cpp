#include "services/wire/wire.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "common/diagnosis/changes.hpp"
#include "common/graph/pieces.hpp"
#include "common/graph/placed_loop.hpp"
#include "common/map/map_delta.hpp"
#include "common/map/tile_grid.hpp"
#include "common/marks/mark_book.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "common/math/trigonometry.hpp"
#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/scan_match.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

constexpr auto kMostBeams = static_cast<std::int32_t>(kMaxBeams);
constexpr std::int32_t kMostParts = 4096;
constexpr double kLargestCoordinate_m = 1e6;
constexpr double kLargestVariance = 1e12;  // of a coordinate [m2]; fits into single precision, as the page has it

// The limits of common/ that the .lcm files state too.
static_assert(MostOf(&bot_core::planar_lidar_t::nranges) == kMaxBeams);
static_assert(MostOf(&sweep_t::num_beams) == kMaxBeams);
static_assert(MostOf(&critical_rays_t::num_rays) == kMaxBeams);
static_assert(MostOf(&keyframe_t::num_rays) == kMaxBeams);
static_assert(MostOf(&map_tile_t::num_bytes) == kMaxRunBytes);
static_assert(MostOf(&tracking_state_t::num_fitnesses) == TrackingState::kUsual);
static_assert(MostOf(&tracking_state_t::num_recent) == TrackingState::kRecent);
static_assert(MostOf(&changes_t::num_changes) == ChangeFinder::kMost);
static_assert(MostOf(&map_pieces_t::num_pieces) == MapPieces::kMostPieces);
static_assert(MostOf(&map_pieces_t::num_breaks) == MapPieces::kMostBreaks);
static_assert(MostOf(&map_pieces_t::num_doubts) == MapError::kMostDoubts);
static_assert(MostOf(&map_page_t::num_loops) == kMostPlacedLoops);
static_assert(MostOf(&map_page_t::num_marks) == PlacedMark::kMostOnMap);
static_assert(MostOf(&robot_marks_t::num_marks) == MarkBook::kMostMarks);
static_assert(MostOf(&robot_mark_t::num_points) == Mark::kMostPoints);
static_assert(MostOf(&mark_t::num_points) == Mark::kMostPoints);
static_assert(MostOf(&placed_mark_t::num_points) == Mark::kMostPoints);
static_assert(MostOf(&kept_mark_t::num_fixed) == Mark::kMostPoints);

bool IsShare(double value) { return value >= 0.0 && value <= 1.0; }  // false for NaN

bool IsSpeed(double speed) { return std::abs(speed) <= kFastest; }  // false for NaN

/// No process has taken so long, or has so much memory.
bool IsAmount(double value) { return value >= 0.0 && value <= 1e12; }  // false for NaN

bool IsFlag(std::int8_t value) { return value == 0 || value == 1; }

/// And one more may begin.
bool IsTrajectory(std::int32_t value) { return value >= 0 && value < std::numeric_limits<std::int32_t>::max(); }

bool IsPose(const pose2_t& pose) {
  return std::abs(pose.x_m) <= kLargestCoordinate_m && std::abs(pose.y_m) <= kLargestCoordinate_m &&
         IsWithinFullTurn(pose.yaw_rad);
}

bool IsKeyframe(const keyframe_id_t& id) { return id.trajectory >= 0 && id.number >= 0; }

bool IsNone(const keyframe_id_t& id) { return id.trajectory == -1 && id.number == -1; }

bool IsOlder(const keyframe_id_t& a, const keyframe_id_t& b) {
  return std::pair(a.trajectory, a.number) < std::pair(b.trajectory, b.number);
}

bool IsNoneOrOlder(const keyframe_id_t& a, const keyframe_id_t& b) {
  return IsNone(a) || (IsKeyframe(a) && IsOlder(a, b));
}

/// Whether the keyframe before another one may have that name.
bool IsBefore(const keyframe_id_t& previous, const keyframe_id_t& id) {
  if (id.number > 0) return previous.trajectory == id.trajectory && previous.number == id.number - 1;
  if (id.trajectory > 0) return previous.trajectory == id.trajectory - 1 && previous.number >= 0;
  return IsNone(previous);
}

bool IsWheelMotion(const wheel_motion_t& motion) {
  constexpr double kLeastSigma = 1e-6;  // what is known better than that would be all that counts in a graph
  const auto IsSigma = [](double sigma) { return sigma >= kLeastSigma && sigma <= kLargestCoordinate_m; };
  return IsPose(motion.T_from_to) && IsSigma(motion.sigma_m) && IsSigma(motion.sigma_rad);
}

bool AreWheelMotions(const std::vector<wheel_motion_t>& motions) {
  return std::all_of(motions.begin(), motions.end(), IsWheelMotion);
}

bool IsWheelModel(const wheel_model_t& model) {
  constexpr double kLargestSum = 1e15;
  const auto AreSums = [](const auto& sums) {
    return std::all_of(std::begin(sums), std::end(sums), [](double sum) { return std::abs(sum) <= kLargestSum; });
  };
  return AreSums(model.way_information) && AreSums(model.way_vector) && AreSums(model.turn) &&
         AreSums(model.way_noise) && AreSums(model.turn_noise) && IsAmount(model.wheels_error_m) &&
         IsAmount(model.velocity_error_m) && model.steps >= 0 && model.slips >= 0 && model.slips <= model.steps &&
         model.steps_since_slip >= 0 && IsFlag(model.have_moved) && IsFlag(model.has_start) &&
         IsPose(model.T_map_start) && IsPose(model.T_odom_start);
}

bool IsCovariance(const double (&covariance)[6]) {
  return std::ranges::all_of(covariance, [](double value) { return std::abs(value) <= kLargestVariance; }) &&
         covariance[0] >= 0.0 && covariance[3] >= 0.0 && covariance[5] >= 0.0;
}

bool IsLoop(const loop_t& loop) {
  return IsKeyframe(loop.older) && IsKeyframe(loop.newer) && IsOlder(loop.older, loop.newer) &&
         IsPose(loop.T_older_newer);
}

/// Of a keyframe.
bool IsFinding(const loop_finding_t& finding, const keyframe_id_t& keyframe) {
  return IsKeyframe(finding.older) && IsOlder(finding.older, keyframe) && IsPose(finding.T_older_this) &&
         finding.score >= 0.0 && finding.score <= 1.0 && finding.by >= loop_finding_t::DRIFT &&
         finding.by <= loop_finding_t::ANYWHERE;
}

bool AreFindings(const std::vector<loop_finding_t>& findings, const keyframe_id_t& keyframe) {
  return std::all_of(findings.begin(), findings.end(),
                     [&](const loop_finding_t& finding) { return IsFinding(finding, keyframe); });
}

bool AreConstraints(const std::vector<proximity_constraint_t>& constraints, const keyframe_id_t& keyframe) {
  return std::all_of(constraints.begin(), constraints.end(), [&](const proximity_constraint_t& constraint) {
    return IsKeyframe(constraint.older) && IsOlder(constraint.older, keyframe) && IsPose(constraint.T_older_this);
  });
}

bool IsStretch(const pose_stretch_t& stretch) {
  constexpr std::int64_t kMostKeyframes = std::numeric_limits<std::int32_t>::max();
  return IsKeyframe(stretch.first) && stretch.num_poses >= 1 &&
         std::int64_t{stretch.first.number} + stretch.num_poses <= kMostKeyframes &&
         std::all_of(stretch.poses.begin(), stretch.poses.end(), IsPose);
}

bool IsPlacedLoop(const map_loop_t& loop) {
  return IsPose(loop.T_map_older) && IsPose(loop.T_map_newer) && IsFlag(loop.rejected) && IsFlag(loop.joins);
}

/// So that sums of a few of them stay numbers.
bool IsCount(std::int64_t count) { return count >= 0 && count <= 1'000'000'000'000; }

bool IsPiece(const map_piece_t& piece) { return piece.keyframes >= 0 && piece.scans >= 0 && IsAmount(piece.way_m); }

bool IsBreak(const map_break_t& at) {
  return at.utime >= 0 && at.scan >= 0 && at.seconds >= 0.0 && std::isfinite(at.seconds) && IsPose(at.T_map_before) &&
         at.piece_before >= 1 && at.piece >= 1 && at.reason >= map_break_t::LOST && at.reason <= map_break_t::SESSION;
}

bool IsDoubt(const map_doubt_t& doubt) {
  return std::isfinite(doubt.x_m) && std::isfinite(doubt.y_m) && IsAmount(doubt.off_m);
}

bool IsAmountOrNone(double value) { return value == -1.0 || IsAmount(value); }

bool IsLayout(const map_pieces_t& layout) {
  const double places[] = {layout.off_at_m[0],      layout.off_at_m[1],    layout.way_back_from[0],
                           layout.way_back_from[1], layout.way_back_to[0], layout.way_back_to[1],
                           layout.slip_at_m[0],     layout.slip_at_m[1]};
  return layout.num_all_pieces >= layout.num_pieces && layout.num_all_breaks >= layout.num_breaks &&
         layout.num_matched >= 0 && layout.num_bridged >= 0 && layout.num_bridged <= layout.num_all_breaks &&
         IsAmountOrNone(layout.off_m) && IsAmountOrNone(layout.way_back_m) && IsAmountOrNone(layout.slip_m) &&
         std::ranges::all_of(places, [](double place_m) { return std::isfinite(place_m); }) &&
         std::ranges::all_of(layout.doubts, IsDoubt) && IsCount(layout.num_keyframes) && IsCount(layout.num_closed) &&
         IsCount(layout.num_rejected) && std::all_of(layout.pieces.begin(), layout.pieces.end(), IsPiece) &&
         std::all_of(layout.breaks.begin(), layout.breaks.end(), IsBreak);
}

bool IsPointCovariance(const double (&covariance)[3]) {
  constexpr double kLargest = 1e14;  // where sightings lie 2e6 m apart along both axes, it is 8e12
  const auto& [xx, xy, yy] = covariance;
  return xx > 0.0 && xx <= kLargest && yy > 0.0 && yy <= kLargest && std::abs(xy) <= kLargest;  // false for NaN
}

bool IsFixedPoint(const fixed_point_t& point) {
  constexpr double kFarthest_m = 4.0 * kLargestCoordinate_m;  // of a point of the map from one of its keyframes
  return (IsNone(point.keyframe) || IsKeyframe(point.keyframe)) && std::abs(point.x_m) <= kFarthest_m &&
         std::abs(point.y_m) <= kFarthest_m;
}

/// As a mark of its text has to be, and each point with a keyframe.
bool IsRobotMark(const robot_mark_t& mark) {
  const auto HasKeyframe = [](const fixed_point_t& point) { return IsFixedPoint(point) && !IsNone(point.keyframe); };
  const Mark described{mark.utime,
                       mark.id,
                       mark.kind,
                       mark.name,
                       MarkAction::kSeen,
                       false,
                       Mark::kLargestRadius_m,
                       std::vector<Point>(mark.points.size())};
  return mark.num_sightings >= 1 && IsPointCovariance(mark.covariance) && DescribeFault(described).empty() &&
         std::ranges::all_of(mark.points, HasKeyframe);
}

/// As a mark of its text and points has to be.
bool IsPlacedMark(const placed_mark_t& mark) {
  const PlacedMark placed = FromMessage(mark);
  return mark.num_sightings >= 1 && IsPointCovariance(mark.covariance) && IsFlag(mark.floating) &&
         DescribeFault(placed).empty();
}

/// Of the valid rays of a scan, by their angles.
bool AreRays(const std::vector<float>& angles_rad, const std::vector<float>& ranges_m) {
  const auto IsRange = [](float range_m) { return range_m > 0.0f && range_m <= kLongestRange_m; };
  const auto IsRayAngle = [](float angle_rad) { return std::abs(angle_rad) <= 2.0 * kFullTurn_rad; };
  return std::all_of(ranges_m.begin(), ranges_m.end(), IsRange) &&
         std::all_of(angles_rad.begin(), angles_rad.end(), IsRayAngle) &&
         std::is_sorted(angles_rad.begin(), angles_rad.end());
}

bool AreTimes(const std::vector<float>& times_s) {
  return std::all_of(times_s.begin(), times_s.end(), [](float time_s) {
    return std::abs(time_s) <= kLongestSweep_s;  // false for NaN
  });
}

bool IsCellSize(double cell_size_m) { return cell_size_m >= 0.001 && cell_size_m <= 10.0; }  // false for NaN

bool AreInMap(const std::vector<map_tile_t>& tiles) {
  return std::all_of(tiles.begin(), tiles.end(), [](const map_tile_t& tile) {
    return InMapLimits(TileIndex{tile.tile_x, tile.tile_y});
  });
}

template <class Message>
bool AllInRange(const std::vector<Message>& messages) {
  return std::all_of(messages.begin(), messages.end(), [](const Message& message) { return ValuesInRange(message); });
}

}  // namespace

template <>
bool ValuesInRange(const bot_core::planar_lidar_t& message) {
  return message.utime >= 0 && AreBeamAngles(message.rad0, message.radstep, message.ranges.size()) &&
         (message.nintensities == 0 || message.nintensities == message.nranges);
}

template <>
bool ValuesInRange(const sweep_t& message) {
  return message.utime >= 0 && AreBeamAngles(message.angle_min_rad, message.angle_step_rad, message.range_m.size()) &&
         AreTimes(message.time_s);
}

template <>
bool ValuesInRange(const bot_core::pose_t& message) {
  const auto InRange = [](double value) { return std::abs(value) <= kLargestCoordinate_m; };
  double square = 0.0;
  for (const double part : message.orientation) square += part * part;
  const bool is_rotation = std::abs(square - 1.0) <= 0.01;  // false for NaN
  const auto IsFinite = [](double value) { return std::isfinite(value); };
  const bool rates_finite = std::all_of(message.vel, message.vel + 3, IsFinite) &&
                            std::all_of(message.rotation_rate, message.rotation_rate + 3, IsFinite) &&
                            std::all_of(message.accel, message.accel + 3, IsFinite);
  return message.utime >= 0 && std::all_of(message.pos, message.pos + 3, InRange) && rates_finite &&
         (is_rotation || square == 0.0);
}

template <>
bool ValuesInRange(const critical_rays_t& message) {
  const bool in_order = std::adjacent_find(message.critical.begin(), message.critical.end(), std::greater_equal<>()) ==
                        message.critical.end();
  const bool times_in_range =
      (message.num_times == 0 || message.num_times == message.num_rays) && AreTimes(message.time_s);
  return message.utime >= 0 && AreRays(message.angle_rad, message.range_m) && times_in_range && in_order &&
         (message.critical.empty() || (message.critical.front() >= 0 && message.critical.back() < message.num_rays));
}

template <>
bool ValuesInRange(const scan_match_t& message) {
  const bool axis_in_range = std::abs(message.degenerate_axis[0]) <= 1.0 && std::abs(message.degenerate_axis[1]) <= 1.0;
  return message.utime >= 0 && std::abs(message.x_m) <= kLargestCoordinate_m &&
         std::abs(message.y_m) <= kLargestCoordinate_m && IsWithinFullTurn(message.yaw_rad) &&
         IsShare(message.fitness) && message.evaluations >= 0 && message.best_evaluation >= 0 &&
         message.num_critical >= 0 && message.num_critical <= kMostBeams && message.map_version >= 0 &&
         IsCovariance(message.covariance) && axis_in_range && message.state >= scan_match_t::FIRST &&
         message.state <= scan_match_t::DEGENERATE && IsSpeed(message.twist_x_m_s) && IsSpeed(message.twist_y_m_s) &&
         IsSpeed(message.twist_yaw_rad_s) && IsFlag(message.has_odometry) &&
         std::abs(message.odometry_x_m) <= kLargestCoordinate_m &&
         std::abs(message.odometry_y_m) <= kLargestCoordinate_m && IsWithinFullTurn(message.odometry_yaw_rad) &&
         IsTrajectory(message.trajectory) && IsFlag(message.floating) && AreWheelMotions(message.by_wheels);
}

template <>
bool ValuesInRange(const tracking_state_t& message) {
  return message.num_scans >= 0 && message.num_lost >= 0 && message.num_lost <= message.num_scans &&
         message.newest_utime >= -1 && IsFlag(message.on_finished_map) &&
         std::all_of(message.fitness.begin(), message.fitness.end(), IsShare) && AllInRange(message.recent) &&
         std::cmp_less_equal(message.num_recent, message.num_scans) &&
         (message.num_scans == 0) == message.recent.empty() && IsPose(message.T_local_map) &&
         message.onset >= tracking_state_t::GOES_ON && message.onset <= tracking_state_t::ANYWHERE &&
         IsPose(message.T_map_guess) && IsTrajectory(message.trajectory) && IsFlag(message.floating) &&
         IsWheelModel(message.wheels) && IsAmount(message.motion_error_m);
}

template <>
bool ValuesInRange(const map_delta_t& message) {
  return message.utime >= 0 && message.epoch != 0 && message.version >= 1 && IsCellSize(message.cell_size_m) &&
         message.part >= 0 && message.num_parts <= kMostParts && message.part < message.num_parts &&
         AreInMap(message.tiles) && std::all_of(message.T_new_old.begin(), message.T_new_old.end(), IsPose) &&
         IsTrajectory(message.trajectory) && IsFlag(message.floating);
}

template <>
bool ValuesInRange(const map_page_t& message) {
  return ValuesInRange(message.request) && message.epoch != 0 && message.version >= 0 &&
         IsCellSize(message.cell_size_m) && message.next_tile >= -1 && message.next_match >= -1 &&
         AreInMap(message.tiles) && AllInRange(message.matches) && AllInRange(message.tracking) &&
         std::all_of(message.loops.begin(), message.loops.end(), IsPlacedLoop) &&
         std::all_of(message.layout.begin(), message.layout.end(), IsLayout) &&
         std::all_of(message.marks.begin(), message.marks.end(), IsPlacedMark);
}

template <>
bool ValuesInRange(const map_request_t& message) {
  return message.requester != 0 && message.question >= 0 && message.base_version >= 0 && message.first_tile >= 0 &&
         message.first_match >= -1 && IsFlag(message.whole) && IsFlag(message.settled) &&
         (message.piece == 0 ||
          (message.whole == 1 && message.piece >= 2 && std::cmp_less_equal(message.piece, MapPieces::kMostPieces)));
}

template <>
bool ValuesInRange(const scan_request_t& message) {
  return message.utime >= 0 && message.requester != 0;
}

template <>
bool ValuesInRange(const scan_answer_t& message) {
  const auto is_of_scan = [&](const scan_match_t& match) { return match.utime == message.utime; };
  return message.utime >= 0 && message.epoch != 0 && message.next_utime > message.utime &&
         AllInRange(message.matches) && std::all_of(message.matches.begin(), message.matches.end(), is_of_scan);
}

template <>
bool ValuesInRange(const keyframe_t& message) {
  const auto SquaredLength = [](const auto& axis) { return axis[0] * axis[0] + axis[1] * axis[1]; };
  const auto IsUnit = [](double square) { return std::abs(square - 1.0) <= 0.01; };  // false for NaN
  const double degenerate = SquaredLength(message.degenerate_axis);
  const bool axes_in_range = (degenerate == 0.0 || IsUnit(degenerate)) && IsUnit(SquaredLength(message.walls_axis)) &&
                             std::ranges::all_of(message.walls_sigma, IsAmount);
  return message.utime >= 0 && message.epoch != 0 && IsKeyframe(message.id) && IsBefore(message.previous, message.id) &&
         (IsNone(message.last_update) || IsKeyframe(message.last_update)) &&
         AreRays(message.angle_rad, message.range_m) && IsPose(message.T_previous_this) &&
         AreWheelMotions(message.by_wheels) && IsFlag(message.after_lost) && IsFlag(message.begins_anywhere) &&
         (message.begins_anywhere == 0 || message.id.number == 0) && IsNoneOrOlder(message.as_of, message.id) &&
         axes_in_range && AreConstraints(message.constraints, message.id) && IsFlag(message.searched) &&
         message.num_findings <= message.searched && AreFindings(message.findings, message.id);
}

template <>
bool ValuesInRange(const keyframe_request_t& message) {
  const bool after_in_range = IsNone(message.after) || (IsKeyframe(message.after) && message.epoch != 0);
  return after_in_range && message.marks_held >= -1 && message.num_keyframes >= 1 &&
         std::cmp_less_equal(message.num_keyframes, kMostKeyframesAtOnce);
}

template <>
bool ValuesInRange(const pose_graph_t& message) {
  const bool previous_in_range =
      IsNone(message.previous) || (IsKeyframe(message.previous) && !IsOlder(message.keyframe, message.previous) &&
                                   (message.changed == 0 || IsOlder(message.previous, message.keyframe)));
  const bool constraints_in_range =
      IsNone(message.constraints_wrong_from) ||
      (IsKeyframe(message.constraints_wrong_from) && !IsOlder(message.keyframe, message.constraints_wrong_from));
  return message.utime >= 0 && message.epoch != 0 && IsKeyframe(message.keyframe) && previous_in_range &&
         IsFlag(message.changed) && message.part >= 0 && message.num_parts <= kMostParts &&
         message.part < message.num_parts && AreFindings(message.findings, message.keyframe) && constraints_in_range &&
         std::all_of(message.closed.begin(), message.closed.end(), IsLoop) &&
         std::all_of(message.rejected.begin(), message.rejected.end(), IsLoop) &&
         std::all_of(message.moved.begin(), message.moved.end(), IsStretch);
}

template <>
bool ValuesInRange(const fleet_keyframe_t& message) {
  const auto IsFleetFinding = [](const fleet_finding_t& finding) {
    return finding.map >= 0 && IsKeyframe(finding.keyframe) && IsPose(finding.T_keyframe_this) &&
           IsShare(finding.score) && (finding.by == loop_finding_t::DRIFT || finding.by == loop_finding_t::ANYWHERE);
  };
  return message.heard_utime >= 0 && IsFlag(message.solved) && message.num_keyframes == 1 &&
         AllInRange(message.keyframes) && std::all_of(message.findings.begin(), message.findings.end(), IsFleetFinding);
}

template <>
bool ValuesInRange(const fleet_pose_t& message) {
  return message.utime >= 0 && message.epoch != 0 && message.scan_utime >= 0 && message.num_keyframes >= 0 &&
         IsPose(message.T_common_map) && IsCovariance(message.covariance) && IsFlag(message.floating) &&
         message.piece >= 1 && IsFlag(message.heard) &&
         std::all_of(message.trajectories.begin(), message.trajectories.end(), IsTrajectory);
}

namespace {

bool IsChange(const change_t& change) {
  const auto IsSide = [](double side_m) { return IsAmount(side_m) && side_m > 0.0; };
  return change.kind >= change_t::NEW && change.kind <= change_t::GONE &&
         IsPose({change.middle_m[0], change.middle_m[1], change.yaw_rad}) && IsSide(change.length_m) &&
         IsSide(change.width_m) && change.num_places >= 1;
}

}  // namespace

template <>
bool ValuesInRange(const changes_t& message) {
  return message.utime >= 0 && message.epoch != 0 &&
         std::all_of(message.changes.begin(), message.changes.end(), IsChange);
}

template <>
bool ValuesInRange(const mark_t& message) {
  return message.action >= mark_t::SEEN && message.action <= mark_t::REMOVED && IsFlag(message.in_map_frame) &&
         DescribeFault(FromMessage(message)).empty();
}

template <>
bool ValuesInRange(const kept_mark_t& message) {
  return ValuesInRange(message.mark) && message.num_fixed == message.mark.num_points &&
         std::ranges::all_of(message.fixed, IsFixedPoint);
}

template <>
bool ValuesInRange(const robot_marks_t& message) {
  constexpr std::int64_t kLargestChecksum = std::numeric_limits<std::uint32_t>::max();
  return message.epoch != 0 && message.checksum >= 0 && message.checksum <= kLargestChecksum &&
         (message.num_marks == 0 || message.checksum != 0) && std::ranges::all_of(message.marks, IsRobotMark);
}

template <>
bool ValuesInRange(const fleet_marks_t& message) {
  return message.map >= 0 && ValuesInRange(message.marks);
}

template <>
bool ValuesInRange(const service_status_t& message) {
  const double amounts[] = {message.latency_p50_ms, message.latency_p95_ms, message.latency_p99_ms,
                            message.latency_max_ms, message.resident_mb};
  return message.utime >= 0 && IsCount(message.num_left_out) && message.num_latencies >= 0 &&
         std::all_of(std::begin(amounts), std::end(amounts), IsAmount);
}

template <>
bool ValuesInRange(const journal_head_t& message) {
  return message.utime >= 0 && message.epoch != 0 && IsFlag(message.finished_map);
}

template <>
bool ValuesInRange(const journal_check_t& message) {
  return message.utime >= 0 && message.first_byte >= 0 && message.num_bytes >= 0 && message.synced_bytes >= 0;
}

}  // namespace crsm
