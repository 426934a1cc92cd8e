#pragma once

#include <cstdint>
#include <string_view>

namespace crsm {

// What an MCAP file is made of, for who writes one and who reads one. Source: mcap.dev/spec.

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

enum class McapOpcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kDataEnd = 0x0f,
};

}  // namespace crsm
