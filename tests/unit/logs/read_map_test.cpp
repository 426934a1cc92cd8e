#include "common/logs/read_map.hpp"

#include <zlib.h>

#include <string>

#include "catch.hpp"
#include "common/results/pictures.hpp"
#include "scratch.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

/// A folder of results, whose map has two rows of three cells.
class ResultsFolder : public ScratchFolder {
 public:
  ResultsFolder() {
    Write("map.yaml", "image: map.png\nresolution: 0.05\norigin: [-0.100000, 0.150000, 0.0]\nnegate: 0\n");
    Write("map.png", EncodeMap({3, 2, 0, 0, 0.05, {0, 1, 128, 255, 254, 127}}));
  }
};

/// A picture that says something else of itself: at 0 of its header its width in four bytes, at 4 its height, at 8 the
/// bits of a sample, at 9 its colour type.
std::string WithHeader(std::string png, std::size_t at, const std::string& bytes) {
  constexpr std::size_t kName = 12;  // of the first chunk; its data follow, and a checksum of both
  constexpr std::size_t kHeader = 16;
  constexpr std::size_t kChecksum = 29;
  png.replace(kHeader + at, bytes.size(), bytes);
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(png.data() + kName), kChecksum - kName);
  for (std::size_t i = 0; i < 4; ++i) png[kChecksum + i] = static_cast<char>(sum >> (24 - 8 * i));
  return png;
}

}  // namespace

TEST_CASE("a map is read from its picture and its place: each pixel is a cell, and the lowest row the first") {
  const ResultsFolder results;
  const DenseGrid grid = ReadMap(results.path());
  CHECK(grid.width_cells == 3);
  CHECK(grid.height_cells == 2);
  CHECK(grid.origin_x_cells == -2);
  CHECK(grid.origin_y_cells == 3);
  CHECK(grid.cell_size_m == 0.05);
  CHECK(grid.cells == std::vector<std::uint8_t>{0, 1, 128, 255, 254, 127});

  const ByteMap map = ReadByteMap(results.path());
  CHECK(map.geometry().cell_size_m() == 0.05);
  CHECK(map.At({-2, 3}) == 0);
  CHECK(map.At({0, 3}) == 128);
  CHECK(map.At({-2, 4}) == 255);
  CHECK(map.At({0, 4}) == kUnexploredByte);
}

TEST_CASE("what is no map of ours is refused, and the file named") {
  const ResultsFolder results;
  const auto CheckRefused = [&](const char* file, const std::string& reason) {
    CHECK(ErrorOf([&] { ReadByteMap(results.path()); }).starts_with((results / file).string() + reason));
  };
  for (const std::string text :
       {"", "resolution: 0.05", "resolution: 0\norigin: [0, 0, 0]", "resolution: -1\norigin: [0, 0, 0]",
        "resolution: nan\norigin: [0, 0, 0]", "resolution: 0.05\norigin: [3300, 0, 0]",
        "resolution: 0.05\norigin: [0, nan, 0]", "resolution: 1e-300\norigin: [1e5, 0, 0]"}) {
    CAPTURE(text);
    results.Write("map.yaml", text);
    CheckRefused("map.yaml", ": must have lines 'resolution: METRES' and 'origin: [X, Y, YAW]'");
  }
  results.Write("map.yaml", "resolution: 1\norigin: [0, 0, 0]");
  CHECK_NOTHROW(ReadByteMap(results.path()));
  const std::string good = EncodeMap({2, 1, 0, 0, 0.05, {0, 255}});
  const std::vector<std::pair<std::string, std::string>> pictures{
      {WithHeader(good, 9, "\2"), ": is no 8-bit grey picture"},    // colours
      {WithHeader(good, 8, "\x10"), ": is no 8-bit grey picture"},  // 16 bits
      {WithHeader(good, 0, std::string("\0\1\0\0\0\1\0\0", 8)), ": has 65536 x 65536 pixels, more than"},
      {EncodeMap({70000, 1, 0, 0, 0.05, std::vector<std::uint8_t>(70000, 9)}), ": is larger than a map can be"},
      {good.substr(0, good.size() - 20), ": cannot be read as a picture: "},
      {"", ": cannot be read as a picture: "},
      {"P5 1 1 255 x", ": cannot be read as a picture: "}};
  for (const auto& [picture, reason] : pictures) {
    results.Write("map.png", picture);
    CheckRefused("map.png", reason);
  }
  fs::remove(results / "map.png");
  for (const char* missing : {"map.png", "map.yaml"}) {
    fs::remove(results / missing);
    const std::string error = ErrorOf([&] { ReadByteMap(results.path()); });
    CHECK(error == "cannot read " + (results / missing).string() + ": No such file or directory");
  }
}

}  // namespace crsm
