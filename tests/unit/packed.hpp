#pragma once

#include <bzlib.h>
#include <lz4frame.h>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

#include <array>
#include <string>
#include <string_view>

namespace crsm {

inline constexpr std::array<const char*, 5> kCompressionNames{"bz2", "gzip", "lz4", "xz", "zstd"};

/// What a compression makes of bytes.
inline std::string Pack(std::string_view compression, const std::string& bytes) {
  std::string packed(2 * bytes.size() + 100'000, '\0');
  auto* const to = reinterpret_cast<std::uint8_t*>(packed.data());
  const auto* const from = reinterpret_cast<const std::uint8_t*>(bytes.data());
  std::size_t size = 0;
  if (compression == "bz2") {
    auto size_in_32_bits = static_cast<unsigned>(packed.size());
    BZ2_bzBuffToBuffCompress(packed.data(), &size_in_32_bits, const_cast<char*>(bytes.data()),
                             static_cast<unsigned>(bytes.size()), 9, 0, 0);
    size = size_in_32_bits;
  } else if (compression == "gzip") {
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY);
    stream.next_in = const_cast<std::uint8_t*>(from);
    stream.avail_in = static_cast<unsigned>(bytes.size());
    stream.next_out = to;
    stream.avail_out = static_cast<unsigned>(packed.size());
    deflate(&stream, Z_FINISH);
    size = stream.total_out;
    deflateEnd(&stream);
  } else if (compression == "lz4") {
    size = LZ4F_compressFrame(to, packed.size(), from, bytes.size(), nullptr);
  } else if (compression == "xz") {
    lzma_easy_buffer_encode(6, LZMA_CHECK_CRC32, nullptr, from, bytes.size(), to, &size, packed.size());
  } else {
    size = ZSTD_compress(to, packed.size(), from, bytes.size(), 1);
  }
  return packed.substr(0, size);
}

}  // namespace crsm
