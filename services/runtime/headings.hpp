#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/parameters.hpp"
#include "common/scan/odometry_buffer.hpp"
#include "services/runtime/laser_types.hpp"

namespace crsm {

/// Where somebody else says that the robot was: of a bot_core.pose_t or an mbot_lcm_msgs.pose2D_t; nothing of any other
/// message, or of a malformed one. HandednessJudge compares its headings with the scans.
std::optional<Odometry> DecodeHeading(std::span<const std::uint8_t> bytes);

/// What mirrored scans do, "turn against the poses on ODOMETRY: ...", what comes of it and what mends it.
/// heading_channel: of the poses that tell. laser: the type of the scans' messages.
std::string DescribeMirrored(const std::string& heading_channel, const LaserType& laser,
                             const ScanParameters& parameters);

}  // namespace crsm
