#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace crsm {

/// The name of a type of lcmtypes/ by its fingerprint, "bot_core.planar_lidar_t"; of any other the fingerprint itself,
/// "a type with fingerprint 0x0123456789abcdef".
std::string NameOfType(std::uint64_t fingerprint);

/// What is wrong with a message that was refused on the channel of a laser, and what mends it.
std::string DescribeRefusedLaser(std::span<const std::uint8_t> bytes);

}  // namespace crsm
