#pragma once

#include <cstdint>
#include <string>

namespace crsm {

/// 8-bit grey or blue, green, red; row by row from the top, without gaps.
struct Pixels {
  int width = 0;
  int height = 0;
  int channels = 1;  ///< 1: grey, 3: blue, green, red
  const std::uint8_t* bytes = nullptr;
};

/// The bytes of a PNG file, the same for the same pixels. Throws std::runtime_error where there are none, or there is
/// no memory for it.
std::string EncodePng(const Pixels& pixels);

}  // namespace crsm
