#pragma once

#include <cstdint>
#include <string_view>

namespace crsm {

/// CRC-32 as of gzip; `crc` of what came before.
std::uint32_t Crc32(std::string_view bytes, std::uint32_t crc = 0);

}  // namespace crsm
