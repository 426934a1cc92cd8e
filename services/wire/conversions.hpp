#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/diagnosis/changes.hpp"
#include "common/graph/pieces.hpp"
#include "common/graph/placed_loop.hpp"
#include "common/map/map_delta.hpp"
#include "common/marks/mark.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/odometry_buffer.hpp"
#include "common/scan/scan_match.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

// Messages to and from the types of common/. Messages are checked ones (Decode), so nothing here fails.

LaserScan FromMessage(const bot_core::planar_lidar_t& message);
LaserScan FromMessage(const sweep_t& message);
/// Without the times of the beams, for which this type has no room.
bot_core::planar_lidar_t ToMessage(const LaserScan& scan);
sweep_t ToSweepMessage(const LaserScan& scan);

/// Calls `use` with the message that says all of a scan: where it has times a sweep_t, else what the LCM world knows.
template <class Use>
void AsLaserMessage(const LaserScan& scan, Use&& use) {
  scan.times_s.empty() ? use(ToMessage(scan)) : use(ToSweepMessage(scan));
}

ScanMatch FromMessage(const scan_match_t& message);
scan_match_t ToMessage(const ScanMatch& match);

TileChange FromMessage(const map_tile_t& message);
map_tile_t ToMessage(const TileChange& change);

Pose2 FromMessage(const pose2_t& message);
pose2_t ToMessage(const Pose2& pose);
PlacedLoop FromMessage(const map_loop_t& message);
map_loop_t ToMessage(const PlacedLoop& loop);
std::vector<MapChange> FromMessage(const changes_t& message);
/// utime: of the newest scan.
changes_t ToMessage(const std::vector<MapChange>& changes, std::int64_t utime, std::int64_t epoch);
MapPieces FromMessage(const map_pieces_t& message);
map_pieces_t ToMessage(const MapPieces& pieces);

Mark FromMessage(const mark_t& message);
mark_t ToMessage(const Mark& mark);
FixedMark FromMessage(const kept_mark_t& message);
kept_mark_t ToMessage(const FixedMark& fixed);
std::vector<AnchoredMark> FromMessage(const robot_marks_t& message);
/// With their checksum. Points are told to a millimetre: what moves less is no other place.
robot_marks_t ToMessage(const std::vector<AnchoredMark>& marks, std::int64_t epoch);
PlacedMark FromMessage(const placed_mark_t& message);
placed_mark_t ToMessage(const PlacedMark& mark);

CriticalRays FromMessage(const critical_rays_t& message);
critical_rays_t ToMessage(const CriticalRays& scan);

std::optional<WheelMotion> FromMessages(const std::vector<wheel_motion_t>& messages);
std::vector<wheel_motion_t> ToMessages(const std::optional<WheelMotion>& motion);

WheelModel::State FromMessage(const wheel_model_t& message);
wheel_model_t ToMessage(const WheelModel::State& state);

TrackingState FromMessage(const tracking_state_t& message);
tracking_state_t ToMessage(const TrackingState& tracking);

/// A pose for other people's viewers, and a match's.
bot_core::pose_t ToPoseMessage(std::int64_t utime, const Pose2& T_map_laser);
bot_core::pose_t ToPoseMessage(const ScanMatch& match);

/// ODOMETRY. A message of its own says that a scan has none: a matcher in lockstep waits for it.
Odometry FromMessage(const bot_core::pose_t& message);
bot_core::pose_t ToMessage(const Odometry& odometry);

}  // namespace crsm
