#include "services/library/plain_png.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/logs/png_file.hpp"

namespace crsm {
namespace {

/// One block of deflate with the codes that are fixed.
class Deflater {
 public:
  Deflater() {
    Append(1, 1);  // the last block
    Append(1, 2);  // of fixed codes
  }

  /// The byte, so many times.
  void AppendRun(std::uint8_t byte, std::size_t count) {
    AppendByte(byte);
    --count;
    constexpr std::size_t kShortest = 3;
    constexpr std::size_t kLongest = 258;
    while (count >= kShortest) {
      const std::size_t length = std::min(count, kLongest);
      AppendRepeat(static_cast<int>(length));
      count -= length;
    }
    while (count-- > 0) AppendByte(byte);
  }

  std::string Finish() {
    AppendCode(0, 7);  // the end of the block
    if (num_bits_ > 0) bytes_ += static_cast<char>(bits_);
    return std::move(bytes_);
  }

 private:
  void AppendByte(std::uint8_t byte) {
    byte < 144 ? AppendCode(0b00110000u + byte, 8) : AppendCode(0b110010000u + (byte - 144u), 9);
  }

  /// The last byte, 3 to 258 times more.
  void AppendRepeat(int length) {
    constexpr int kNumCodes = 29;
    constexpr std::array<int, kNumCodes> kShortest{3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
                                                   31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
    const auto code = static_cast<int>(std::ranges::upper_bound(kShortest, length) - kShortest.begin()) - 1;
    const int num_more_bits = code < 8 || code == kNumCodes - 1 ? 0 : (code - 4) / 4;
    const auto symbol = static_cast<unsigned>(257 + code);
    symbol < 280 ? AppendCode(symbol - 256, 7) : AppendCode(0b11000000u + (symbol - 280), 8);
    Append(static_cast<unsigned>(length - kShortest[static_cast<std::size_t>(code)]), num_more_bits);
    AppendCode(0, 5);  // one byte back
  }

  /// Codes begin with their highest bit, all else with the lowest.
  void AppendCode(unsigned code, int num_bits) {
    for (int bit = num_bits - 1; bit >= 0; --bit) Append(code >> bit & 1, 1);
  }
  void Append(unsigned number, int num_bits) {
    bits_ |= number << num_bits_;
    for (num_bits_ += num_bits; num_bits_ >= 8; num_bits_ -= 8, bits_ >>= 8) bytes_ += static_cast<char>(bits_ & 0xff);
  }

  std::string bytes_;
  unsigned bits_ = 0;
  int num_bits_ = 0;
};

/// RFC 1950, 8.
std::uint32_t Adler32(const std::vector<std::uint8_t>& bytes) {
  constexpr std::uint32_t kPrime = 65521;
  std::uint32_t a = 1;
  std::uint32_t b = 0;
  for (const std::uint8_t byte : bytes) {
    a = (a + byte) % kPrime;
    b = (b + a) % kPrime;
  }
  return b << 16 | a;
}

/// From the top row on, each with the filter before it: less the row above.
std::vector<std::uint8_t> Filter(const DenseGrid& grid) {
  std::vector<std::uint8_t> filtered;
  for (int row = grid.height_cells - 1; row >= 0; --row) {
    filtered.push_back(kPngLessThoseAbove);
    for (int column = 0; column < grid.width_cells; ++column) {
      const std::uint8_t above = row + 1 < grid.height_cells ? grid.cells[grid.IndexOf(column, row + 1)] : 0;
      filtered.push_back(static_cast<std::uint8_t>(grid.cells[grid.IndexOf(column, row)] - above));
    }
  }
  return filtered;
}

}  // namespace

std::string EncodePlainMap(const DenseGrid& grid) {
  const std::vector<std::uint8_t> filtered = Filter(grid);
  Deflater deflater;
  for (auto at = filtered.begin(); at != filtered.end();) {
    const auto end = std::find_if(at, filtered.end(), [&](std::uint8_t byte) { return byte != *at; });
    deflater.AppendRun(*at, static_cast<std::size_t>(end - at));
    at = end;
  }
  std::string file = BeginPng(grid.width_cells, grid.height_cells, 1);
  AppendPngChunk("IDAT", "\x78\x01" + deflater.Finish() + BigEndian(Adler32(filtered)), file);
  AppendPngChunk("IEND", "", file);
  return file;
}

}  // namespace crsm
