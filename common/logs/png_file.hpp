#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace crsm {

// A PNG file but for its pixels. Source: PNG (Third Edition), 5 and 9.

// How the bytes of a row are filtered before they are compressed.
inline constexpr std::uint8_t kPngAsTheyAre = 0;
inline constexpr std::uint8_t kPngLessThoseAbove = 2;

/// Its beginning, for pixels of 8 bits a channel. channels: 1: grey, 3: red, green, blue.
std::string BeginPng(int width, int height, int channels);

/// A chunk: "IDAT" of pixels, "IEND" at the end.
void AppendPngChunk(std::string_view type, std::string_view data, std::string& png);

/// A number as it stands in such files.
std::string BigEndian(std::uint32_t number);

}  // namespace crsm
