#include "common/logs/png_file.hpp"

#include "common/logs/crc32.hpp"

namespace crsm {

std::string BigEndian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xff);
  return bytes;
}

void AppendPngChunk(std::string_view type, std::string_view data, std::string& png) {
  png += BigEndian(static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = png.size();
  png += type;
  png += data;
  png += BigEndian(Crc32(std::string_view(png).substr(begin)));
}

std::string BeginPng(int width, int height, int channels) {
  using namespace std::string_literals;
  constexpr char kDepth = 8;
  const char colour = channels == 1 ? 0 : 2;
  std::string png = "\x89PNG\r\n\x1a\n";
  AppendPngChunk("IHDR",
                 BigEndian(static_cast<std::uint32_t>(width)) + BigEndian(static_cast<std::uint32_t>(height)) + kDepth +
                     colour + "\0\0\0"s,
                 png);
  return png;
}

}  // namespace crsm
