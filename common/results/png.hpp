#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace crsm {

/// 8-bit grey or red, green, blue; row by row from the top, without gaps.
struct Pixels {
  int width = 0;
  int height = 0;
  int channels = 1;  ///< 1: grey, 3: red, green, blue
  const std::uint8_t* bytes = nullptr;
};

/// Makes PNG files, the same for the same pixels. Of a picture that is made again and again, the rows that are as they
/// were are not compressed again. Source: PNG (Third Edition), 5, 9 and 10; RFC 1950, 2.2; RFC 1951, 3.2.3.
class PngEncoder {
 public:
  enum class Use { kOnce, kAgain };  ///< for one picture, or for what it will be later, too: the rows are remembered
  explicit PngEncoder(Use use = Use::kAgain) : use_(use) {}

  /// The bytes of a file. Throws std::invalid_argument where a side has no pixels.
  std::string Encode(const Pixels& pixels);

 private:
  /// Rows that are compressed alone, and as they were then.
  struct Strip {
    std::vector<std::uint8_t> pixels;
    std::string compressed;
    unsigned long checksum = 0;  ///< Adler-32 of what was compressed
    std::size_t num_bytes = 0;   ///< of that
  };

  Use use_;
  int width_ = 0;
  int channels_ = 0;
  std::vector<Strip> strips_;  ///< from the top
};

/// The same for one picture.
std::string EncodePng(const Pixels& pixels);

}  // namespace crsm
