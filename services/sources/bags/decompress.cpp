#include "services/sources/bags/decompress.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <optional>

#include "services/sources/bags/bag_reader.hpp"

namespace crsm {
namespace {

/// How far bytes could be unpacked.
struct Unpacked {
  std::size_t size = 0;
  bool is_whole = false;
};

/// Nothing if the bytes are damaged or become more than `most`.
using Unpack = std::optional<Unpacked> (*)(std::string_view packed, char* to, std::size_t most);

std::optional<Unpacked> UnpackBzip2(std::string_view packed, char* to, std::size_t most) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return std::nullopt;
  stream.next_in = const_cast<char*>(packed.data());
  stream.avail_in = static_cast<unsigned>(packed.size());  // both sizes are below kMostChunkBytes
  stream.next_out = to;
  stream.avail_out = static_cast<unsigned>(most);
  const int code = BZ2_bzDecompress(&stream);
  const Unpacked unpacked{most - stream.avail_out, code == BZ_STREAM_END};
  const bool is_starved = code == BZ_OK && stream.avail_in == 0;
  BZ2_bzDecompressEnd(&stream);
  return unpacked.is_whole || is_starved ? std::optional(unpacked) : std::nullopt;
}

/// One frame or several.
std::optional<Unpacked> UnpackLz4(std::string_view packed, char* to, std::size_t most) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) return std::nullopt;
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                     &LZ4F_freeDecompressionContext);
  Unpacked unpacked;
  while (!packed.empty()) {
    std::size_t num_out = most - unpacked.size;
    std::size_t num_in = packed.size();
    const std::size_t hint = LZ4F_decompress(raw, to + unpacked.size, &num_out, packed.data(), &num_in, nullptr);
    if (LZ4F_isError(hint) || (num_in == 0 && num_out == 0)) return std::nullopt;
    unpacked.size += num_out;
    unpacked.is_whole = hint == 0;
    packed.remove_prefix(num_in);
  }
  return unpacked;
}

/// One frame or several.
std::optional<Unpacked> UnpackZstd(std::string_view packed, char* to, std::size_t most) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) return std::nullopt;
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  ZSTD_outBuffer out{to, most, 0};
  std::size_t hint = 1;  // 0 at the end of a frame
  while (in.pos < in.size) {
    const std::size_t before = in.pos + out.pos;
    hint = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(hint) || in.pos + out.pos == before) return std::nullopt;
  }
  // What still waits within, where all bytes are in.
  while (hint != 0 && out.pos < out.size) {
    const std::size_t before = out.pos;
    hint = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(hint)) return std::nullopt;
    if (out.pos == before) break;
  }
  return Unpacked{out.pos, hint == 0};
}

Unpack FindUnpack(std::string_view compression) {
  if (compression == "bz2") return &UnpackBzip2;
  if (compression == "lz4") return &UnpackLz4;
  if (compression == "zstd") return &UnpackZstd;
  return nullptr;
}

}  // namespace

std::unique_ptr<MemoryRange> Decompress(const PackedBytes& packed) {
  if (packed.unpacked_size > kMostChunkBytes || packed.bytes.size() > kMostChunkBytes) return nullptr;
  const Unpack unpack = FindUnpack(packed.compression);
  if (!unpack) return nullptr;
  const auto size = static_cast<std::size_t>(packed.unpacked_size);
  std::unique_ptr<char[]> bytes(new char[size]);  // not set to zero: a size that is a lie takes no memory
  const auto unpacked = unpack(packed.bytes, bytes.get(), size);
  const bool is_good = unpacked && (packed.is_cut || (unpacked->is_whole && unpacked->size == size));
  return is_good ? std::make_unique<MemoryRange>(std::move(bytes), unpacked->size) : nullptr;
}

std::size_t SizeOfZstdMessage(std::string_view message) {
  constexpr std::string_view kMagic = "\x28\xB5\x2F\xFD";  // CDR and ROS 1 messages of ours do not begin so
  if (!message.starts_with(kMagic)) return 0;
  const unsigned long long size = ZSTD_getFrameContentSize(message.data(), message.size());
  return size > kMostMessageBytes ? 0 : static_cast<std::size_t>(size);  // unknown and wrong ones are huge
}

PlainMessage::PlainMessage(std::string_view message) : data_(message) {
  const std::size_t size = SizeOfZstdMessage(message);
  if (size == 0) return;
  unpacked_ = Decompress({"zstd", message, size});
  data_ = unpacked_ ? unpacked_->All() : std::string_view();
}

}  // namespace crsm
