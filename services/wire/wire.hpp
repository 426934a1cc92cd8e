#pragma once

#include <wire_fields/bot_core/planar_lidar_t.hpp>
#include <wire_fields/bot_core/pose_t.hpp>
#include <wire_fields/crsm/change_t.hpp>
#include <wire_fields/crsm/changes_t.hpp>
#include <wire_fields/crsm/critical_rays_t.hpp>
#include <wire_fields/crsm/fixed_point_t.hpp>
#include <wire_fields/crsm/fleet_finding_t.hpp>
#include <wire_fields/crsm/fleet_keyframe_t.hpp>
#include <wire_fields/crsm/fleet_marks_t.hpp>
#include <wire_fields/crsm/fleet_pose_t.hpp>
#include <wire_fields/crsm/journal_check_t.hpp>
#include <wire_fields/crsm/journal_head_t.hpp>
#include <wire_fields/crsm/kept_mark_t.hpp>
#include <wire_fields/crsm/keyframe_id_t.hpp>
#include <wire_fields/crsm/keyframe_request_t.hpp>
#include <wire_fields/crsm/keyframe_t.hpp>
#include <wire_fields/crsm/loop_finding_t.hpp>
#include <wire_fields/crsm/map_break_t.hpp>
#include <wire_fields/crsm/map_delta_t.hpp>
#include <wire_fields/crsm/map_loop_t.hpp>
#include <wire_fields/crsm/map_page_t.hpp>
#include <wire_fields/crsm/map_piece_t.hpp>
#include <wire_fields/crsm/map_pieces_t.hpp>
#include <wire_fields/crsm/map_request_t.hpp>
#include <wire_fields/crsm/mark_t.hpp>
#include <wire_fields/crsm/placed_mark_t.hpp>
#include <wire_fields/crsm/pose_graph_t.hpp>
#include <wire_fields/crsm/pose_stretch_t.hpp>
#include <wire_fields/crsm/robot_marks_t.hpp>
#include <wire_fields/crsm/scan_answer_t.hpp>
#include <wire_fields/crsm/scan_match_t.hpp>
#include <wire_fields/crsm/scan_request_t.hpp>
#include <wire_fields/crsm/service_status_t.hpp>
#include <wire_fields/crsm/sweep_t.hpp>
#include <wire_fields/crsm/tracking_state_t.hpp>
#include <wire_fields/crsm/wheel_model_t.hpp>
#include <wire_fields/crsm/wheel_motion_t.hpp>

#include "services/wire/wire_reader.hpp"

namespace crsm {

// The types of the bus, as lcmtypes/ has them, and for each a check of its values.

inline constexpr std::size_t kMostKeyframesAtOnce = 64;

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
bool ValuesInRange(const map_page_t& message);
template <>
bool ValuesInRange(const map_request_t& message);
template <>
bool ValuesInRange(const scan_request_t& message);
template <>
bool ValuesInRange(const scan_answer_t& message);
template <>
bool ValuesInRange(const keyframe_t& message);
template <>
bool ValuesInRange(const keyframe_request_t& message);
template <>
bool ValuesInRange(const pose_graph_t& message);
template <>
bool ValuesInRange(const fleet_keyframe_t& message);
template <>
bool ValuesInRange(const fleet_pose_t& message);
template <>
bool ValuesInRange(const changes_t& message);
template <>
bool ValuesInRange(const mark_t& message);
template <>
bool ValuesInRange(const kept_mark_t& message);
template <>
bool ValuesInRange(const robot_marks_t& message);
template <>
bool ValuesInRange(const fleet_marks_t& message);
template <>
bool ValuesInRange(const service_status_t& message);
template <>
bool ValuesInRange(const journal_head_t& message);
template <>
bool ValuesInRange(const journal_check_t& message);

}  // namespace crsm
