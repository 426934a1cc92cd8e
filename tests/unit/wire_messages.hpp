#pragma once

#include <cstdint>
#include <vector>

#include "services/runtime/wire.hpp"

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

inline bot_core::pose_t PoseMessage() {
  return {5, {1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}, {0.5, 0.5, 0.5, 0.5}, {7.0, 8.0, 9.0}, {10.0, 11.0, 12.0}};
}

inline critical_rays_t CriticalRaysMessage() { return {5, 3, {-0.5f, 0.0f, 0.5f}, {1.0f, 2.0f, 3.0f}, 2, {0, 2}}; }

inline scan_match_t ScanMatchMessage() {
  return {5,           1.0,
          -2.0,        0.5,
          0.75,        4000,
          3000,        70,
          12,          {4e-4, 0.0, 0.0, 9e-4, 0.0, 1e-5},
          {0.6, -0.8}, scan_match_t::DEGENERATE,
          1,           3.0,
          4.0,         -0.5};
}

inline tracking_state_t TrackingStateMessage() {
  return {8, 1, 5, 0, 2, {0.5, 0.75}, 1, {ScanMatchMessage()}, {0.5, -1.0, 0.25}};
}

inline map_delta_t MapDeltaMessage() {
  map_delta_t message{};
  message.utime = 5;
  message.epoch = 99;
  message.version = 8;
  message.base_version = 7;
  message.cell_size_m = 0.05;
  message.num_parts = 1;
  message.num_tiles = 2;
  message.tiles = {{-3, 4, 5, {0, 0, 0, 1, 9}}, {1023, -1024, 0, {}}};
  message.num_matches = 1;
  message.matches = {ScanMatchMessage()};
  message.asked_utime = 5;
  message.num_asked = 1;
  message.asked = {ScanMatchMessage()};
  message.num_tracking = 1;
  message.tracking = {TrackingStateMessage()};
  return message;
}

inline map_request_t MapRequestMessage() { return {77, 99, 8, 2, 3, 5, 1, 1}; }

inline service_status_t ServiceStatusMessage() {
  return {5, "map_updater", "1.0", 42,  "",  2,   {"handled", "lost"}, {9, 1}, 1, {"seed"}, {"7"},
          9, 1.0,           1.5,   2.0, 3.0, 40.0};
}

inline journal_head_t JournalHeadMessage() {
  return {5, 99, 1, "1.0", 2, {"cell_size_m", "join_hits"}, {"0.05", "true"}};
}

inline journal_check_t JournalCheckMessage() { return {5, 300, 200, 100, -7}; }

}  // namespace crsm
