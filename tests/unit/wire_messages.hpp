#pragma once

#include <algorithm>
#include <array>
#include <botlab/lidar_nranges_t.hpp>
#include <botlab/lidar_t.hpp>
#include <cstdint>
#include <sensor_msgs/LaserScan.hpp>
#include <vector>

#include "services/wire/wire.hpp"

// Fields of a message that are not named are 0.
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"

namespace crsm {

template <class Message>
std::vector<std::uint8_t> Encode(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

// A well-formed message of each type, small enough to try every byte of it.

inline bot_core::planar_lidar_t LidarMessage() {
  return {5, 3, {1.0f, 0.0f, 2.5f}, 3, {7.0f, 8.0f, 9.0f}, -1.5f, 0.25f};
}

/// A sweep of the student robots, whose count of beams has had two names.
template <class BotlabLidar>
BotlabLidar BotlabMessage(std::int32_t BotlabLidar::*count) {
  BotlabLidar message{};
  message.utime = 5;
  message.*count = 2;
  message.ranges = {1.0f, 2.0f};
  message.thetas = {0.0f, 6.0f};
  message.times = {1, 2};
  message.intensities = {3.0f, 4.0f};
  return message;
}
inline botlab::lidar_t BotlabLidarMessage() { return BotlabMessage(&botlab::lidar_t::num_ranges); }
inline botlab::lidar_nranges_t BotlabLidarNrangesMessage() { return BotlabMessage(&botlab::lidar_nranges_t::nranges); }

inline sensor_msgs::LaserScan RosScanMessage() {
  sensor_msgs::LaserScan scan{};
  scan.header = {7, {100, 250'000'900}, "laser"};
  scan.angle_min = -0.5f;
  scan.angle_max = 0.25f;
  scan.angle_increment = 0.25f;
  scan.range_min = 0.5f;
  scan.range_max = 10.0f;
  scan.ranges = {0.5f, 0.25f, 11.0f, 10.0f};
  scan.ranges_length = 4;
  return scan;
}

inline sweep_t SweepMessage() { return {5, 3, {1.0f, 0.0f, 2.5f}, {-0.1f, -0.05f, 0.0f}, -1.5f, 0.25f}; }

inline bot_core::pose_t PoseMessage() {
  return {5, {1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}, {0.5, 0.5, 0.5, 0.5}, {7.0, 8.0, 9.0}, {10.0, 11.0, 12.0}};
}

inline critical_rays_t CriticalRaysMessage() {
  return {5, 3, {-0.5f, 0.0f, 0.5f}, {1.0f, 2.0f, 3.0f}, 2, {0, 2}, 3, {-0.1f, -0.05f, 0.0f}};
}

inline wheel_motion_t WheelMotionMessage() { return {{0.25, -0.5, 0.125}, 0.02, 0.01}; }

inline wheel_model_t WheelModelMessage() {
  return {{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0},
          {1.5, 2.5, 3.5, 4.5},
          {0.5, 0.25},
          {1.0, 2.0, 3.0, 4.0, 5.0},
          {6.0, 7.0, 8.0, 9.0, 10.0},
          0.02,
          0.03,
          40,
          2,
          7,
          1,
          1,
          {1.0, 2.0, 0.5},
          {3.0, 4.0, -0.5}};
}

inline scan_match_t ScanMatchMessage() {
  return {5,
          1.0,
          -2.0,
          0.5,
          0.75,
          4000,
          3000,
          70,
          12,
          {4e-4, 0.0, 0.0, 9e-4, 0.0, 1e-5},
          {0.6, -0.8},
          scan_match_t::DEGENERATE,
          1,
          3.0,
          4.0,
          -0.5,
          1.5,
          -0.25,
          3.0,
          2,
          1,
          1,
          {WheelMotionMessage()}};
}

inline tracking_state_t TrackingStateMessage() {
  return {8,
          1,
          5,
          0,
          2,
          {0.5, 0.75},
          1,
          {ScanMatchMessage()},
          {0.5, -1.0, 0.25},
          2,
          {1.5, 2.0, -0.5},
          2,
          1,
          WheelModelMessage(),
          0.0125};
}

inline map_delta_t MapDeltaMessage() {
  return {.utime = 5,
          .epoch = 99,
          .version = 8,
          .cell_size_m = 0.05,
          .part = 0,
          .num_parts = 1,
          .num_tiles = 2,
          .tiles = {{-3, 4, 5, {0, 0, 0, 1, 9}}, {1023, -1024, 0, {}}},
          .num_corrections = 1,
          .T_new_old = {{0.25, -0.5, 0.125}},
          .trajectory = 2,
          .floating = 1};
}

inline map_request_t MapRequestMessage() {
  return {.requester = 77,
          .question = 4,
          .epoch = 99,
          .base_version = 7,
          .first_tile = 2,
          .first_match = 3,
          .whole = 1,
          .settled = 1,
          .piece = 2};
}

inline map_pieces_t MapPiecesMessage() {
  return {.num_all_pieces = 3,
          .num_all_breaks = 4,
          .num_matched = 90,
          .num_bridged = 1,
          .num_keyframes = 9,
          .num_closed = 5,
          .num_rejected = 2,
          .off_m = 0.75,
          .off_at_m = {4.5, -2.5},
          .num_doubts = 1,
          .doubts = {{4.5, -2.5, 0.5}},
          .way_back_from = {1.0, 2.0},
          .way_back_to = {-3.0, 4.0},
          .way_back_m = 0.25,
          .slip_at_m = {7.0, 8.0},
          .slip_m = 0.375,
          .num_pieces = 2,
          .pieces = {{7, 60, 12.5}, {2, 30, 0.5}},
          .num_breaks = 1,
          .breaks = {{9, 40, 1.5, {1.0, -2.0, 0.25}, 1, 2, map_break_t::SESSION}}};
}

inline mark_t MarkMessage() { return {5, "v1", "victim", "in the hall", mark_t::SEEN, 1, 0.25, 1, {1.5}, {-2.5}}; }

inline kept_mark_t KeptMarkMessage() { return {MarkMessage(), 1, {{{1, 8}, 0.5, 0.25}}}; }

inline robot_marks_t RobotMarksMessage() {
  return {99, 7, 1, {{5, "v1", "victim", "in the hall", 2, {0.25, 0.0, 0.25}, 1, {{{0, 3}, 1.5, -2.5}}}}};
}

inline fleet_marks_t FleetMarksMessage() { return {2, RobotMarksMessage()}; }

inline placed_mark_t PlacedMarkMessage() {
  return {5, "zone", "keep-out", "stairs", 1, {0.25, 0.0, 0.25}, 1, 3, {0.0, 2.0, 1.0}, {0.0, 0.0, 1.5}};
}

inline map_page_t MapPageMessage() {
  return {.request = MapRequestMessage(),
          .epoch = 99,
          .version = 8,
          .cell_size_m = 0.05,
          .next_tile = 4,
          .next_match = 4,
          .num_tiles = 2,
          .tiles = {{-3, 4, 5, {0, 0, 0, 1, 9}}, {1023, -1024, 0, {}}},
          .num_matches = 1,
          .matches = {ScanMatchMessage()},
          .num_tracking = 1,
          .tracking = {TrackingStateMessage()},
          .num_loops = 2,
          .loops = {{{1.0, 2.0, 0.5}, {3.0, -4.0, 6.0}, 1, 0}, {{}, {}, 0, 1}},
          .num_layouts = 1,
          .layout = {MapPiecesMessage()},
          .num_marks = 1,
          .marks = {PlacedMarkMessage()}};
}

inline scan_request_t ScanRequestMessage() { return {.utime = 5, .requester = 77}; }

inline scan_answer_t ScanAnswerMessage() {
  return {.utime = 5, .epoch = 99, .requester = 77, .next_utime = 9, .num_matches = 1, .matches = {ScanMatchMessage()}};
}

inline loop_finding_t LoopFindingMessage() { return {{0, 3}, {0.5, -0.25, 0.125}, 0.75, loop_finding_t::NEARBY}; }

inline keyframe_t KeyframeMessage() {
  keyframe_t message{};
  message.utime = 5;
  message.epoch = 99;
  message.id = {1, 8};
  message.previous = {1, 7};
  message.last_update = {1, 6};
  message.num_rays = 3;
  message.angle_rad = {-0.5f, 0.0f, 0.5f};
  message.range_m = {1.0f, 2.0f, 3.0f};
  message.T_previous_this = {0.5, -0.25, 0.125};
  message.num_by_wheels = 1;
  message.by_wheels = {WheelMotionMessage()};
  message.after_lost = 1;
  message.as_of = {1, 4};
  message.degenerate_axis[0] = 0.6;
  message.degenerate_axis[1] = -0.8;
  message.walls_axis[1] = 1.0;
  std::ranges::copy(std::array{0.02, 0.01, 0.005}, message.walls_sigma);
  message.num_constraints = 1;
  message.constraints = {{{0, 2}, {1.5, 0.25, -0.5}}};
  message.searched = 1;
  message.num_findings = 1;
  message.findings = {LoopFindingMessage()};
  return message;
}

inline keyframe_request_t KeyframeRequestMessage() { return {99, {1, 3}, 40, 7}; }

inline pose_graph_t PoseGraphMessage() {
  pose_graph_t message{};
  message.utime = 5;
  message.epoch = 99;
  message.keyframe = {1, 8};
  message.previous = {1, 6};
  message.changed = 1;
  message.num_parts = 1;
  message.num_findings = 1;
  message.findings = {LoopFindingMessage()};
  message.constraints_wrong_from = {1, 7};
  message.num_closed = 2;
  message.closed = {{{0, 9}, {1, 8}, {0.5, 0.0, 0.25}}, {{1, 1}, {1, 7}, {}}};
  message.num_rejected = 1;
  message.rejected = {{{1, 2}, {1, 6}, {1.0, 2.0, 3.0}}};
  message.num_moved = 2;
  message.moved = {{{0, 9}, 1, {{1.0, 2.0, 0.5}}}, {{1, 7}, 2, {{2.0, 2.0, 0.5}, {3.0, 2.0, -0.5}}}};
  return message;
}

inline fleet_pose_t FleetPoseMessage() {
  return {5, "robot1/", 99, 7, 3, {1.0, 2.0, 0.5}, {0.5, 0.0, 0.0, 0.25, 0.0, 0.125}, 1, 2, 1, 2, {0, 3}};
}

inline changes_t ChangesMessage() { return {5, 99, 1, {{change_t::GONE, {1.0, -2.0}, 0.75, 0.5, 0.25, 4, 3}}}; }

inline fleet_keyframe_t FleetKeyframeMessage() {
  return {"robot1/", 5, 1, 1, {KeyframeMessage()}, 1, {{2, {0, 9}, {1.0, 2.0, 0.5}, 0.75, loop_finding_t::ANYWHERE}}};
}

inline service_status_t ServiceStatusMessage() {
  return {5, "map_updater", "1.0", 42,  "",  3,   2, {"handled", "lost"}, {9, 1}, 1, {"seed"}, {"7"},
          9, 1.0,           1.5,   2.0, 3.0, 40.0};
}

inline journal_head_t JournalHeadMessage() {
  return {5, 99, 1, "1.0", 2, {"cell_size_m", "join_hits"}, {"0.05", "true"}};
}

inline journal_check_t JournalCheckMessage() { return {5, 300, 200, 100, -7}; }

}  // namespace crsm
