#include "common/logs/map_files.hpp"

#include <fmt/format.h>

namespace crsm {

DenseGrid MakeUnexploredCell(double cell_size_m) {
  return {1, 1, 0, 0, cell_size_m > 0.0 ? cell_size_m : 1.0, {kUnexploredByte}};
}

std::string FormatMapYaml(const DenseGrid& grid, const std::string& picture) {
  // map_server takes (255 - byte) / 255 for the probability that a cell is occupied, more than occupied_thresh for a
  // wall, less than free_thresh for free, and what is between for unknown: 127 alone, as IsOccupied and IsFree have it.
  return fmt::format(
      "image: {}\n"
      "resolution: {}\n"
      "origin: [{:.6f}, {:.6f}, 0.0]\n"
      "negate: 0\n"
      "occupied_thresh: 0.504\n"
      "free_thresh: 0.5\n",
      picture, grid.cell_size_m, grid.origin_x_cells * grid.cell_size_m, grid.origin_y_cells * grid.cell_size_m);
}

void FormatPgm(const DenseGrid& grid, const Sink& sink) {
  sink(fmt::format("P5\n{} {}\n255\n", grid.width_cells, grid.height_cells));
  const auto width = static_cast<std::size_t>(grid.width_cells);
  for (std::size_t row = grid.cells.size() / width; row > 0; --row) {
    sink({reinterpret_cast<const char*>(grid.cells.data()) + (row - 1) * width, width});
  }
}

}  // namespace crsm
