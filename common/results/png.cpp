#include "common/results/png.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <new>
#include <span>
#include <stdexcept>

#include "common/logs/png_file.hpp"

namespace crsm {
namespace {

constexpr int kStripRows = 64;

/// What makes a small file in little time, by measurement. Maps are flat from row to row; pictures are enlarged, and
/// repeat themselves.
struct Compression {
  std::uint8_t filter;
  int level;
  int strategy;
};

Compression CompressionOf(int channels) {
  return channels == 1 ? Compression{kPngLessThoseAbove, 1, Z_RLE} : Compression{kPngAsTheyAre, 3, Z_DEFAULT_STRATEGY};
}

/// A raw deflate stream of its own for each strip, which ends on a whole byte and is not the last of a file.
class Deflater {
 public:
  explicit Deflater(const Compression& compression) {
    constexpr int kRaw = -15;
    constexpr int kMemory = 8;
    if (deflateInit2(&stream_, compression.level, Z_DEFLATED, kRaw, kMemory, compression.strategy) != Z_OK)
      throw std::bad_alloc();
  }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;

  std::string Compress(std::span<std::uint8_t> bytes) {
    constexpr std::size_t kOfFlush = 16;
    deflateReset(&stream_);
    std::string compressed(deflateBound(&stream_, bytes.size()) + kOfFlush, '\0');
    stream_.next_in = bytes.data();
    stream_.avail_in = static_cast<uInt>(bytes.size());
    stream_.next_out = reinterpret_cast<Bytef*>(compressed.data());
    stream_.avail_out = static_cast<uInt>(compressed.size());
    if (deflate(&stream_, Z_FULL_FLUSH) != Z_OK || stream_.avail_in > 0) throw std::bad_alloc();
    compressed.resize(compressed.size() - stream_.avail_out);
    compressed.shrink_to_fit();
    return compressed;
  }

 private:
  z_stream stream_{};
};

/// The rows of a strip, each with its filter before it. The first one does not hang on the strip above.
std::vector<std::uint8_t> Filter(std::span<const std::uint8_t> pixels, std::size_t row_bytes, std::uint8_t filter) {
  std::vector<std::uint8_t> filtered;
  filtered.reserve(pixels.size() + pixels.size() / row_bytes);
  for (std::size_t at = 0; at < pixels.size(); at += row_bytes) {
    const auto row = pixels.subspan(at, row_bytes);
    const bool by_above = filter == kPngLessThoseAbove && at > 0;
    filtered.push_back(by_above ? kPngLessThoseAbove : kPngAsTheyAre);
    filtered.insert(filtered.end(), row.begin(), row.end());
    if (!by_above) continue;
    const auto above = pixels.subspan(at - row_bytes, row_bytes);
    std::transform(row.begin(), row.end(), above.begin(), filtered.end() - std::ssize(row),
                   [](std::uint8_t byte, std::uint8_t other) { return static_cast<std::uint8_t>(byte - other); });
  }
  return filtered;
}

}  // namespace

std::string PngEncoder::Encode(const Pixels& pixels) {
  using namespace std::string_literals;
  if (pixels.width < 1 || pixels.height < 1) throw std::invalid_argument("PngEncoder: a side without pixels");
  if (width_ != pixels.width || channels_ != pixels.channels) strips_.clear();
  width_ = pixels.width;
  channels_ = pixels.channels;
  const std::size_t row_bytes = static_cast<std::size_t>(width_) * static_cast<std::size_t>(channels_);
  strips_.resize(static_cast<std::size_t>((pixels.height + kStripRows - 1) / kStripRows));

  std::string file = BeginPng(pixels.width, pixels.height, channels_);
  AppendPngChunk("IDAT", "\x78\x01", file);  // the head of the stream that the strips are
  unsigned long checksum = adler32(0, nullptr, 0);
  const Compression compression = CompressionOf(channels_);
  Deflater deflater(compression);
  std::span rest(pixels.bytes, row_bytes * static_cast<std::size_t>(pixels.height));
  for (Strip& strip : strips_) {
    const auto rows = rest.first(std::min(rest.size(), row_bytes * kStripRows));
    rest = rest.subspan(rows.size());
    if (!std::ranges::equal(strip.pixels, rows)) {
      std::vector<std::uint8_t> filtered = Filter(rows, row_bytes, compression.filter);
      strip.compressed = deflater.Compress(filtered);
      strip.num_bytes = filtered.size();
      strip.checksum = adler32(adler32(0, nullptr, 0), filtered.data(), static_cast<uInt>(filtered.size()));
      if (use_ == Use::kAgain) strip.pixels.assign(rows.begin(), rows.end());
    }
    AppendPngChunk("IDAT", strip.compressed, file);
    checksum = adler32_combine(checksum, strip.checksum, static_cast<z_off_t>(strip.num_bytes));
  }
  AppendPngChunk("IDAT", "\x03\0"s + BigEndian(static_cast<std::uint32_t>(checksum)),
                 file);  // an empty block, which is the last
  AppendPngChunk("IEND", "", file);
  return file;
}

std::string EncodePng(const Pixels& pixels) { return PngEncoder(PngEncoder::Use::kOnce).Encode(pixels); }

}  // namespace crsm
