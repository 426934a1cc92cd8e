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
  return UnpackRuns(change.runs, tiles_.Touch(change.index).cells);
}

DenseGrid ByteMap::ToDenseGrid() const {
  DenseGrid grid;
  grid.cell_size_m = geometry_.cell_size_m();
  Cell low{INT_MAX, INT_MAX};
  Cell high{INT_MIN, INT_MIN};
  const auto ForEachExplored = [&](auto&& visit) {
    for (const auto& [index, tile] : tiles_.entries()) {
      for (int offset = 0; offset < kTileCells; ++offset) {
        const std::uint8_t byte = tile->cells[static_cast<std::size_t>(offset)];
        if (byte == kUnexploredByte) continue;
        visit(CellAt(index, offset), byte);
      }
    }
  };
  ForEachExplored([&](Cell cell, std::uint8_t) {
    low = {std::min(low.x, cell.x), std::min(low.y, cell.y)};
    high = {std::max(high.x, cell.x), std::max(high.y, cell.y)};
  });
  if (low.x > high.x) return grid;

  grid.origin_x_cells = low.x;
  grid.origin_y_cells = low.y;
  grid.width_cells = high.x - low.x + 1;
  grid.height_cells = high.y - low.y + 1;
  const auto width = static_cast<std::size_t>(grid.width_cells);
  grid.cells.assign(width * static_cast<std::size_t>(grid.height_cells), kUnexploredByte);
  ForEachExplored([&](Cell cell, std::uint8_t byte) {
    grid.cells[static_cast<std::size_t>(cell.y - low.y) * width + static_cast<std::size_t>(cell.x - low.x)] = byte;
  });
  return grid;
}

}  // namespace crsm
