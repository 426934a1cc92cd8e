#pragma once

#include <bot_core/planar_lidar_t.hpp>
#include <bot_core/pose_t.hpp>
#include <crsm/critical_rays_t.hpp>
#include <crsm/journal_check_t.hpp>
#include <crsm/journal_head_t.hpp>
#include <crsm/keyframe_id_t.hpp>
#include <crsm/keyframe_request_t.hpp>
#include <crsm/keyframe_t.hpp>
#include <crsm/loop_finding_t.hpp>
#include <crsm/map_break_t.hpp>
#include <crsm/map_delta_t.hpp>
#include <crsm/map_loop_t.hpp>
#include <crsm/map_piece_t.hpp>
#include <crsm/map_pieces_t.hpp>
#include <crsm/map_request_t.hpp>
#include <crsm/pose_graph_t.hpp>
#include <crsm/pose_stretch_t.hpp>
#include <crsm/scan_match_t.hpp>
#include <crsm/service_status_t.hpp>
#include <crsm/sweep_t.hpp>
#include <crsm/tracking_state_t.hpp>
#include <crsm/wheel_model_t.hpp>
#include <crsm/wheel_motion_t.hpp>

#include "common/graph/pieces.hpp"
#include "common/graph/placed_loop.hpp"
#include "common/map/map_delta.hpp"
#include "common/match/tracking_state.hpp"
#include "common/scan/laser_scan.hpp"
#include "services/wire/wire_reader.hpp"

namespace crsm {

// The types of the bus, as lcmtypes/ has them: for each its members in their order, with the most elements that an
// array may have, and a check of its values (in wire.cpp).

inline constexpr std::size_t kMostTilesInMessage = 4096;
inline constexpr std::size_t kMostMatchesInMessage = 1024;
inline constexpr std::size_t kMostLoopsInMessage = 1024;
inline constexpr std::size_t kMostPosesInMessage = 2000;
inline constexpr std::size_t kMostKeyframesAtOnce = 64;
inline constexpr std::size_t kMostCounters = 64;
inline constexpr std::size_t kMostParameters = 128;
inline constexpr std::size_t kMostJournalParameters = 256;

template <>
constexpr auto FieldsOf<bot_core::planar_lidar_t>() {
  using T = bot_core::planar_lidar_t;
  return std::tuple(&T::utime, &T::nranges, Array(&T::ranges, &T::nranges, kMaxBeams), &T::nintensities,
                    Array(&T::intensities, &T::nintensities, kMaxBeams), &T::rad0, &T::radstep);
}

template <>
constexpr auto FieldsOf<sweep_t>() {
  using T = sweep_t;
  return std::tuple(&T::utime, &T::num_beams, Array(&T::range_m, &T::num_beams, kMaxBeams),
                    Array(&T::time_s, &T::num_beams, kMaxBeams), &T::angle_min_rad, &T::angle_step_rad);
}

template <>
constexpr auto FieldsOf<bot_core::pose_t>() {
  using T = bot_core::pose_t;
  return std::tuple(&T::utime, &T::pos, &T::vel, &T::orientation, &T::rotation_rate, &T::accel);
}

template <>
constexpr auto FieldsOf<critical_rays_t>() {
  using T = critical_rays_t;
  return std::tuple(&T::utime, &T::num_rays, Array(&T::angle_rad, &T::num_rays, kMaxBeams),
                    Array(&T::range_m, &T::num_rays, kMaxBeams), &T::num_critical,
                    Array(&T::critical, &T::num_critical, kMaxBeams), &T::num_times,
                    Array(&T::time_s, &T::num_times, kMaxBeams));
}

template <>
constexpr auto FieldsOf<pose2_t>() {
  using T = pose2_t;
  return std::tuple(&T::x_m, &T::y_m, &T::yaw_rad);
}

template <>
constexpr auto FieldsOf<wheel_motion_t>() {
  using T = wheel_motion_t;
  return std::tuple(&T::T_from_to, &T::sigma_m, &T::sigma_rad);
}

template <>
constexpr auto FieldsOf<wheel_model_t>() {
  using T = wheel_model_t;
  return std::tuple(&T::way_information, &T::way_vector, &T::turn, &T::delay, &T::way_noise, &T::turn_noise,
                    &T::wheels_error_m, &T::velocity_error_m, &T::steps, &T::slips, &T::steps_since_slip, &T::has_start,
                    &T::T_map_start, &T::T_odom_start, &T::rate_at_start);
}

template <>
constexpr auto FieldsOf<scan_match_t>() {
  using T = scan_match_t;
  return std::tuple(&T::utime, &T::x_m, &T::y_m, &T::yaw_rad, &T::fitness, &T::evaluations, &T::best_evaluation,
                    &T::num_critical, &T::map_version, &T::covariance, &T::degenerate_axis, &T::state, &T::has_odometry,
                    &T::odometry_x_m, &T::odometry_y_m, &T::odometry_yaw_rad, &T::twist_x_m_s, &T::twist_y_m_s,
                    &T::twist_yaw_rad_s, &T::trajectory, &T::floating, &T::num_by_wheels,
                    Array(&T::by_wheels, &T::num_by_wheels, 1));
}

template <>
constexpr auto FieldsOf<map_tile_t>() {
  using T = map_tile_t;
  return std::tuple(&T::tile_x, &T::tile_y, &T::num_bytes, Array(&T::runs, &T::num_bytes, kMaxRunBytes));
}

template <>
constexpr auto FieldsOf<tracking_state_t>() {
  using T = tracking_state_t;
  return std::tuple(&T::num_scans, &T::num_lost, &T::newest_utime, &T::on_finished_map, &T::num_fitnesses,
                    Array(&T::fitness, &T::num_fitnesses, TrackingState::kUsual), &T::num_recent,
                    Array(&T::recent, &T::num_recent, TrackingState::kRecent), &T::T_local_map, &T::onset,
                    &T::T_map_guess, &T::trajectory, &T::floating, &T::wheels, &T::motion_error_m);
}

template <>
constexpr auto FieldsOf<map_loop_t>() {
  using T = map_loop_t;
  return std::tuple(&T::T_map_older, &T::T_map_newer, &T::taken_out, &T::joins);
}

template <>
constexpr auto FieldsOf<map_piece_t>() {
  using T = map_piece_t;
  return std::tuple(&T::keyframes, &T::scans, &T::way_m);
}

template <>
constexpr auto FieldsOf<map_break_t>() {
  using T = map_break_t;
  return std::tuple(&T::utime, &T::scan, &T::seconds, &T::T_map_before, &T::piece_before, &T::piece, &T::reason);
}

template <>
constexpr auto FieldsOf<map_pieces_t>() {
  using T = map_pieces_t;
  return std::tuple(&T::num_all_pieces, &T::num_all_breaks, &T::num_matched, &T::num_bridged, &T::num_pieces,
                    Array(&T::pieces, &T::num_pieces, MapPieces::kMostPieces), &T::num_breaks,
                    Array(&T::breaks, &T::num_breaks, MapPieces::kMostBreaks));
}

template <>
constexpr auto FieldsOf<map_delta_t>() {
  using T = map_delta_t;
  return std::tuple(&T::utime, &T::epoch, &T::version, &T::base_version, &T::cell_size_m, &T::part, &T::num_parts,
                    &T::num_requests, Array(&T::request, &T::num_requests, 1), &T::next_tile, &T::next_match,
                    &T::num_tiles, Array(&T::tiles, &T::num_tiles, kMostTilesInMessage), &T::num_matches,
                    Array(&T::matches, &T::num_matches, kMostMatchesInMessage), &T::num_asked,
                    Array(&T::asked, &T::num_asked, 1), &T::num_moved, Array(&T::T_new_old, &T::num_moved, 1),
                    &T::trajectory, &T::floating, &T::num_tracking, Array(&T::tracking, &T::num_tracking, 1),
                    &T::num_loops, Array(&T::loops, &T::num_loops, kMostPlacedLoops), &T::num_layouts,
                    Array(&T::layout, &T::num_layouts, 1));
}

template <>
constexpr auto FieldsOf<map_request_t>() {
  using T = map_request_t;
  return std::tuple(&T::requester, &T::question, &T::epoch, &T::base_version, &T::first_tile, &T::first_match,
                    &T::asked_utime, &T::whole, &T::settled, &T::piece);
}

template <>
constexpr auto FieldsOf<keyframe_id_t>() {
  using T = keyframe_id_t;
  return std::tuple(&T::trajectory, &T::number);
}

template <>
constexpr auto FieldsOf<pose_stretch_t>() {
  using T = pose_stretch_t;
  return std::tuple(&T::first, &T::num_poses, Array(&T::poses, &T::num_poses, kMostPosesInMessage));
}

template <>
constexpr auto FieldsOf<loop_finding_t>() {
  using T = loop_finding_t;
  return std::tuple(&T::older, &T::T_older_this, &T::score, &T::by);
}

template <>
constexpr auto FieldsOf<keyframe_t>() {
  using T = keyframe_t;
  return std::tuple(&T::utime, &T::epoch, &T::id, &T::previous, &T::last_update, &T::num_rays,
                    Array(&T::angle_rad, &T::num_rays, kMaxBeams), Array(&T::range_m, &T::num_rays, kMaxBeams),
                    &T::T_previous_this, &T::num_by_wheels, Array(&T::by_wheels, &T::num_by_wheels, 1), &T::after_lost,
                    &T::begins_anywhere, &T::as_of, &T::num_open_axes, &T::open_axis, &T::num_ties, &T::tied_to,
                    &T::T_tied_this, &T::searched, &T::num_findings, Array(&T::findings, &T::num_findings, 1));
}

template <>
constexpr auto FieldsOf<keyframe_request_t>() {
  using T = keyframe_request_t;
  return std::tuple(&T::epoch, &T::after, &T::num_keyframes);
}

template <>
constexpr auto FieldsOf<loop_t>() {
  using T = loop_t;
  return std::tuple(&T::older, &T::newer, &T::T_older_newer);
}

template <>
constexpr auto FieldsOf<pose_graph_t>() {
  using T = pose_graph_t;
  return std::tuple(&T::utime, &T::epoch, &T::keyframe, &T::previous, &T::changed, &T::part, &T::num_parts,
                    &T::num_findings, Array(&T::findings, &T::num_findings, 1), &T::ties_wrong_from, &T::num_closed,
                    Array(&T::closed, &T::num_closed, kMostLoopsInMessage), &T::num_taken_out,
                    Array(&T::taken_out, &T::num_taken_out, kMostLoopsInMessage), &T::num_moved,
                    Array(&T::moved, &T::num_moved, kMostPosesInMessage));
}

template <>
constexpr auto FieldsOf<service_status_t>() {
  using T = service_status_t;
  return std::tuple(&T::utime, &T::name, &T::version, &T::pid, &T::state, &T::num_counters,
                    Array(&T::counter_name, &T::num_counters, kMostCounters),
                    Array(&T::counter_value, &T::num_counters, kMostCounters), &T::num_parameters,
                    Array(&T::parameter_name, &T::num_parameters, kMostParameters),
                    Array(&T::parameter_value, &T::num_parameters, kMostParameters), &T::num_latencies,
                    &T::latency_p50_ms, &T::latency_p95_ms, &T::latency_p99_ms, &T::latency_max_ms, &T::resident_mb);
}

template <>
constexpr auto FieldsOf<journal_head_t>() {
  using T = journal_head_t;
  return std::tuple(&T::utime, &T::epoch, &T::finished_map, &T::version, &T::num_parameters,
                    Array(&T::parameter_name, &T::num_parameters, kMostJournalParameters),
                    Array(&T::parameter_value, &T::num_parameters, kMostJournalParameters));
}

template <>
constexpr auto FieldsOf<journal_check_t>() {
  using T = journal_check_t;
  return std::tuple(&T::utime, &T::first_byte, &T::num_bytes, &T::synced_bytes, &T::crc);
}

template <>
bool ValuesInRange(const bot_core::planar_lidar_t& message);
template <>
bool ValuesInRange(const sweep_t& message);
template <>
bool ValuesInRange(const bot_core::pose_t& message);
template <>
bool ValuesInRange(const critical_rays_t& message);
template <>
bool ValuesInRange(const scan_match_t& message);
template <>
bool ValuesInRange(const tracking_state_t& message);
template <>
bool ValuesInRange(const map_delta_t& message);
template <>
bool ValuesInRange(const map_request_t& message);
template <>
bool ValuesInRange(const keyframe_t& message);
template <>
bool ValuesInRange(const keyframe_request_t& message);
template <>
bool ValuesInRange(const pose_graph_t& message);
template <>
bool ValuesInRange(const service_status_t& message);
template <>
bool ValuesInRange(const journal_head_t& message);
template <>
bool ValuesInRange(const journal_check_t& message);

}  // namespace crsm
