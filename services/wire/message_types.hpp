#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "common/parameters.hpp"
#include "services/wire/laser_types.hpp"

namespace crsm {

/// The name of a type of lcmtypes/ by its fingerprint, "bot_core.planar_lidar_t"; of any other the fingerprint itself,
/// "a type with fingerprint 0x0123456789abcdef".
std::string NameOfType(std::uint64_t fingerprint);

/// What is wrong with a message that was refused on the channel of a laser, and what mends it.
std::string DescribeRefusedLaser(std::span<const std::uint8_t> bytes);

/// What mirrored scans do, "turn against the poses on ODOMETRY: ...", what comes of it and what mends it.
/// pose_channel: of the poses that tell. laser: the type of the scans' messages.
std::string DescribeMirrored(const std::string& pose_channel, const LaserType& laser,
                             const LaserMessageOptions& options);

}  // namespace crsm
