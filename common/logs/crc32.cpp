#include "common/logs/crc32.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

namespace crsm {
namespace {

constexpr std::size_t kAtOnce = 8;  // bytes, each with a table of its own
using Tables = std::array<std::array<std::uint32_t, 256>, kAtOnce>;

constexpr Tables MakeTables() {
  constexpr std::uint32_t kPolynomial = 0xedb88320;  // of IEEE 802.3, the lowest bit first
  Tables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? kPolynomial : 0);
    tables[0][byte] = crc;
  }
  for (std::size_t byte = 0; byte < 256; ++byte) {
    for (std::size_t i = 1; i < kAtOnce; ++i) {
      const std::uint32_t before = tables[i - 1][byte];
      tables[i][byte] = before >> 8 ^ tables[0][before & 0xff];
    }
  }
  return tables;
}

constexpr Tables kTables = MakeTables();

}  // namespace

std::uint32_t Crc32(std::string_view bytes, std::uint32_t crc) {
  static_assert(std::endian::native == std::endian::little);
  crc = ~crc;
  for (; bytes.size() >= kAtOnce; bytes.remove_prefix(kAtOnce)) {
    std::uint64_t next;
    std::memcpy(&next, bytes.data(), kAtOnce);
    next ^= crc;
    crc = 0;
    for (std::size_t i = 0; i < kAtOnce; ++i) crc ^= kTables[kAtOnce - 1 - i][next >> 8 * i & 0xff];
  }
  for (const char byte : bytes) crc = crc >> 8 ^ kTables[0][(crc ^ static_cast<unsigned char>(byte)) & 0xff];
  return ~crc;
}

}  // namespace crsm
