#include "common/logs/read_map.hpp"

#include <fmt/core.h>
#include <png.h>

#include <cmath>
#include <cstdio>
#include <sstream>
#include <stdexcept>
#include <string>

#include "common/logs/map_picture.hpp"
#include "common/logs/regular_file.hpp"

namespace crsm {
namespace {

/// A grid that knows where it lies, and has no cells yet.
DenseGrid ReadPlace(const std::filesystem::path& path) {
  std::istringstream yaml(ReadWholeFile(path));
  double resolution_m = 0.0;
  double origin_x_m = NAN;
  double origin_y_m = NAN;
  for (std::string line; std::getline(yaml, line);) {
    if (std::sscanf(line.c_str(), "resolution: %lf", &resolution_m) == 1) continue;
    if (std::sscanf(line.c_str(), "origin: [%lf, %lf", &origin_x_m, &origin_y_m) == 2) continue;
  }
  const double x_cells = std::round(origin_x_m / resolution_m);
  const double y_cells = std::round(origin_y_m / resolution_m);
  if (!(resolution_m > 0.0) || !(std::abs(x_cells) <= kMaxCell) || !(std::abs(y_cells) <= kMaxCell)) {
    throw std::runtime_error(fmt::format(
        "{}: must have lines 'resolution: METRES' and 'origin: [X, Y, YAW]', with X and Y within {} pixels of 0",
        path.string(), kMaxCell));
  }
  DenseGrid grid;
  grid.origin_x_cells = static_cast<int>(x_cells);
  grid.origin_y_cells = static_cast<int>(y_cells);
  grid.cell_size_m = resolution_m;
  return grid;
}

/// libpng's image, which frees what it has made.
struct Png : png_image {
  explicit Png(const std::string& bytes) : png_image{} {
    version = PNG_IMAGE_VERSION;
    png_image_begin_read_from_memory(this, bytes.data(), bytes.size());
  }
  Png(const Png&) = delete;
  Png& operator=(const Png&) = delete;
  ~Png() { png_image_free(this); }

  bool failed() const { return PNG_IMAGE_FAILED(*this); }
};

}  // namespace

DenseGrid ReadMap(const std::filesystem::path& dir) {
  constexpr std::int64_t kMostCells = kMostTilesInRectangle * kTileCells;
  DenseGrid grid = ReadPlace(dir / "map.yaml");
  const std::string path = (dir / FindPicture(dir)).string();
  const std::string bytes = ReadWholeFile(path);
  Png png(bytes);
  if (png.failed()) throw std::runtime_error(fmt::format("{}: cannot be read as a picture: {}", path, png.message));
  if (png.format != PNG_FORMAT_GRAY) throw std::runtime_error(fmt::format("{}: is no 8-bit grey picture", path));
  if (std::int64_t{png.width} * png.height > kMostCells) {
    throw std::runtime_error(
        fmt::format("{}: has {} x {} pixels, more than a map can have cells", path, png.width, png.height));
  }
  grid.width_cells = static_cast<int>(png.width);
  grid.height_cells = static_cast<int>(png.height);
  grid.cells.resize(PNG_IMAGE_SIZE(png));
  // The last row of a picture is the lowest one of the map: a negative stride.
  png_image_finish_read(&png, nullptr, grid.cells.data(), -grid.width_cells, nullptr);
  if (png.failed()) throw std::runtime_error(fmt::format("{}: cannot be read as a picture: {}", path, png.message));
  return grid;
}

ByteMap ReadByteMap(const std::filesystem::path& dir) {
  const DenseGrid grid = ReadMap(dir);
  ByteMap map(grid.cell_size_m);
  for (int row = 0; row < grid.height_cells; ++row) {
    for (int column = 0; column < grid.width_cells; ++column) {
      const std::uint8_t byte = grid.cells[grid.IndexOf(column, row)];
      if (byte == kUnexploredByte) continue;
      if (!map.Set({grid.origin_x_cells + column, grid.origin_y_cells + row}, byte)) {
        throw std::runtime_error(fmt::format("{}: is larger than a map can be", (dir / "map.png").string()));
      }
    }
  }
  return map;
}

}  // namespace crsm
