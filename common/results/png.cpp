#include "common/results/png.hpp"

#include <png.h>

#include <csetjmp>
#include <exception>
#include <stdexcept>

namespace crsm {
namespace {

void Append(png_structp png, png_bytep data, std::size_t size) {
  try {
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), size);
  } catch (const std::exception& error) {
    png_error(png, error.what());  // no exception goes through C
  }
}

/// libpng's way of saying that something went wrong: it jumps back to here. Nothing here has a destructor.
bool Write(png_structp png, png_infop info, const Pixels& pixels) {
  constexpr int kCompression = 6;
  constexpr png_uint_32 kLongestSide = 0x7fffffff;
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_user_limits(png, kLongestSide, kLongestSide);
  // Named, so that another version's defaults do not change the bytes.
  png_set_compression_level(png, kCompression);
  png_set_compression_strategy(png, 0);  // zlib's Z_DEFAULT_STRATEGY
  png_set_IHDR(png, info, static_cast<png_uint_32>(pixels.width), static_cast<png_uint_32>(pixels.height), 8,
               pixels.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_bgr(png);
  const std::size_t row_bytes = static_cast<std::size_t>(pixels.width) * static_cast<std::size_t>(pixels.channels);
  for (std::size_t row = 0; row < static_cast<std::size_t>(pixels.height); ++row) {
    png_write_row(png, pixels.bytes + row * row_bytes);
  }
  png_write_end(png, info);
  return true;
}

void Ignore(png_structp, png_const_charp) {}
[[noreturn]] void Jump(png_structp png, png_const_charp) { png_longjmp(png, 1); }

}  // namespace

std::string EncodePng(const Pixels& pixels) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, Jump, Ignore);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (info) png_set_write_fn(png, &bytes, Append, nullptr);
  const bool written = info && Write(png, info, pixels);
  png_destroy_write_struct(&png, &info);
  if (!written) throw std::runtime_error("a PNG file cannot be made: a side without pixels, or no memory");
  return bytes;
}

}  // namespace crsm
