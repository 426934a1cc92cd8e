#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string_view>

#include "services/base/file_window.hpp"

namespace crsm {

/// No chunk is larger than that; recorders make them of about 1 MB, or as large as their largest message.
inline constexpr std::uint64_t kMostChunkBytes = std::uint64_t{256} << 20;

/// Bytes in memory.
class MemoryRange : public ByteRange {
 public:
  MemoryRange(std::unique_ptr<char[]> bytes, std::size_t size) : bytes_(std::move(bytes)), size_(size) {}

  std::uint64_t size() const override { return size_; }
  std::string_view At(std::uint64_t offset, std::size_t count) override {
    return All().substr(static_cast<std::size_t>(std::min(offset, size())), count);
  }
  std::string_view All() const { return {bytes_.get(), size_}; }

 private:
  std::unique_ptr<char[]> bytes_;
  std::size_t size_;
};

struct PackedBytes {
  std::string_view compression;  ///< "bz2", "lz4" (frames) or "zstd"
  std::string_view bytes;
  std::uint64_t unpacked_size = 0;  ///< the most that they may become, where they are cut
  bool is_cut = false;              ///< the file ends before they do
};

/// What bytes were before they were compressed, as far as they go if they are cut. Nothing if they are damaged, of
/// another size than was said, or of more than kMostChunkBytes, or if the compression is none of these.
std::unique_ptr<MemoryRange> Decompress(const PackedBytes& packed);

/// Of a message that rosbag2 has compressed alone: how long it was before. 0 if it is none, or longer than
/// kMostMessageBytes.
std::size_t SizeOfZstdMessage(std::string_view message);

/// A message as it was before rosbag2 has perhaps compressed it alone; empty if it is damaged.
class PlainMessage {
 public:
  explicit PlainMessage(std::string_view message);
  std::string_view data() const { return data_; }

 private:
  std::unique_ptr<MemoryRange> unpacked_;
  std::string_view data_;
};

}  // namespace crsm
