#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/scan/odometry_buffer.hpp"

namespace crsm {

/// Whether a message is of a type that tells a pose of the robot: bot_core.pose_t, or mbot's mbot_lcm_msgs.pose2D_t.
bool IsPoseMessage(std::span<const std::uint8_t> bytes);

/// What such a message tells; nothing if it is of another type, or malformed.
std::optional<Odometry> DecodePose(std::span<const std::uint8_t> bytes);

}  // namespace crsm
