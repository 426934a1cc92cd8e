#include "common/map/byte_map.hpp"

#include <algorithm>
#include <climits>

namespace crsm {

std::uint8_t ByteMap::At(Cell cell) const {
  const Tile* tile = tiles_.Find(TileOf(cell));
  return tile ? tile->cells[static_cast<std::size_t>(OffsetInTile(cell))] : kUnexploredByte;
}

bool ByteMap::Set(Cell cell, std::uint8_t byte) {
  const TileIndex index = TileOf(cell);
  if (!tiles_.HasRoomFor(index)) return false;
  tiles_.Touch(index).cells[static_cast<std::size_t>(OffsetInTile(cell))] = byte;
  return true;
}

bool ByteMap::Apply(const TileChange& change) {
  if (!tiles_.HasRoomFor(change.index) || !RunsFit(change.runs)) return false;
  if (change.runs.empty()) return true;
  TileBytes& cells = tiles_.Touch(change.index).cells;
  UnpackRuns(change.runs, cells);
  if (cells == kUnexploredBytes) tiles_.Remove(change.index);
  return true;
}

CellRectangle ByteMap::FindTiled() const {
  Cell low{INT_MAX, INT_MAX};
  Cell high{INT_MIN, INT_MIN};
  for (const auto& [index, tile] : tiles_.entries()) {
    const auto [first, last] = CellsOf(index);
    low = {std::min(low.x, first.x), std::min(low.y, first.y)};
    high = {std::max(high.x, last.x), std::max(high.y, last.y)};
  }
  return {low, high};
}

/// Around all explored cells; its low end is beyond its high one if there are none.
CellRectangle ByteMap::FindExplored() const {
  Cell low{INT_MAX, INT_MAX};
  Cell high{INT_MIN, INT_MIN};
  for (const auto& [index, tile] : tiles_.entries()) {
    const auto [first, last] = CellsOf(index);
    if (first.x >= low.x && first.y >= low.y && last.x <= high.x && last.y <= high.y) continue;  // most are inside
    for (int offset = 0; offset < kTileCells; ++offset) {
      if (tile->cells[static_cast<std::size_t>(offset)] == kUnexploredByte) continue;
      const Cell cell = CellAt(index, offset);
      low = {std::min(low.x, cell.x), std::min(low.y, cell.y)};
      high = {std::max(high.x, cell.x), std::max(high.y, cell.y)};
    }
  }
  return {low, high};
}

DenseGrid ByteMap::ToDenseGrid() const {
  DenseGrid grid;
  grid.cell_size_m = geometry_.cell_size_m();
  const auto [low, high] = FindExplored();
  if (low.x > high.x) return grid;

  grid.origin_x_cells = low.x;
  grid.origin_y_cells = low.y;
  grid.width_cells = high.x - low.x + 1;
  grid.height_cells = high.y - low.y + 1;
  const auto width = static_cast<std::size_t>(grid.width_cells);
  grid.cells.assign(width * static_cast<std::size_t>(grid.height_cells), kUnexploredByte);
  for (const auto& [index, tile] : tiles_.entries()) {
    const auto [first, last] = CellsOf(index);
    const int x_low = std::max(first.x, low.x);
    const int x_end = std::min(last.x, high.x) + 1;
    if (x_low >= x_end) continue;
    for (int y = std::max(first.y, low.y); y <= std::min(last.y, high.y); ++y) {
      const auto* row = tile->cells.data() + OffsetInTile({x_low, y});
      const std::size_t to = static_cast<std::size_t>(y - low.y) * width + static_cast<std::size_t>(x_low - low.x);
      std::copy_n(row, x_end - x_low, grid.cells.begin() + static_cast<std::ptrdiff_t>(to));
    }
  }
  return grid;
}

}  // namespace crsm
