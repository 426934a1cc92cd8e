#include "common/map/map_delta.hpp"

#include <algorithm>
#include <bit>
#include <climits>
#include <cstring>

namespace crsm {
namespace {

constexpr int kMaxGap = 4;  // cells; as long as the header of a new run

/// The next cell that differs, `cell` or later; kTileCells if there is none. Eight cells are compared at a time, of
/// which the first is the lowest byte.
int FindChange(const TileBytes& before, const TileBytes& after, int cell) {
  static_assert(std::endian::native == std::endian::little);
  constexpr int kAtOnce = 8;
  for (; cell + kAtOnce <= kTileCells; cell += kAtOnce) {
    std::uint64_t a, b;
    std::memcpy(&a, before.data() + cell, kAtOnce);
    std::memcpy(&b, after.data() + cell, kAtOnce);
    if (a != b) return cell + std::countr_zero(a ^ b) / 8;
  }
  while (cell < kTileCells && before[static_cast<std::size_t>(cell)] == after[static_cast<std::size_t>(cell)]) ++cell;
  return cell;
}

bool RunsFit(std::span<const std::uint8_t> runs) {
  std::size_t cell = 0;
  for (std::size_t at = 0; at < runs.size();) {
    if (runs.size() - at < 4) return false;
    const std::size_t skip = runs[at] * 256u + runs[at + 1];
    const std::size_t count = runs[at + 2] * 256u + runs[at + 3];
    cell += skip + count;
    at += 4;
    if (count == 0 || cell > kTileCells || runs.size() - at < count) return false;
    at += count;
  }
  return true;
}

}  // namespace

std::vector<std::uint8_t> PackRuns(const TileBytes& before, const TileBytes& after) {
  std::array<std::uint8_t, kMaxRunBytes> runs;
  auto* to = runs.data();
  const auto PushTwoBytes = [&](int value) {
    *to++ = static_cast<std::uint8_t>(value >> 8);
    *to++ = static_cast<std::uint8_t>(value & 0xff);
  };
  int end_of_last = 0;
  for (int cell = FindChange(before, after, 0); cell < kTileCells;) {
    int end = cell + 1;
    int next = FindChange(before, after, end);
    for (; next < kTileCells && next - end <= kMaxGap; next = FindChange(before, after, end)) end = next + 1;
    PushTwoBytes(cell - end_of_last);
    PushTwoBytes(end - cell);
    to = std::copy(after.begin() + cell, after.begin() + end, to);
    end_of_last = end;
    cell = next;
  }
  return {runs.data(), to};
}

bool UnpackRuns(std::span<const std::uint8_t> runs, TileBytes& cells) {
  if (!RunsFit(runs)) return false;
  std::size_t cell = 0;
  for (std::size_t at = 0; at < runs.size();) {
    cell += runs[at] * 256u + runs[at + 1];
    const std::size_t count = runs[at + 2] * 256u + runs[at + 3];
    at += 4;
    std::copy_n(runs.begin() + static_cast<std::ptrdiff_t>(at), count,
                cells.begin() + static_cast<std::ptrdiff_t>(cell));
    at += count;
    cell += count;
  }
  return true;
}

CellRectangle FindChangedCells(const TileChange& change) {
  CellRectangle changed{{INT_MAX, INT_MAX}, {INT_MIN, INT_MIN}};
  int end = 0;
  for (std::size_t at = 0; at < change.runs.size();) {
    const int begin = end + change.runs[at] * 256 + change.runs[at + 1];
    const int count = change.runs[at + 2] * 256 + change.runs[at + 3];
    end = begin + count;
    at += static_cast<std::size_t>(4 + count);
    Cell first = CellAt(change.index, begin);
    Cell last = CellAt(change.index, end - 1);
    if (first.y < last.y) {  // from one row into another: the columns between may be any
      first.x = CellsOf(change.index).low.x;
      last.x = CellsOf(change.index).high.x;
    }
    changed.low = {std::min(changed.low.x, first.x), std::min(changed.low.y, first.y)};
    changed.high = {std::max(changed.high.x, last.x), std::max(changed.high.y, last.y)};
  }
  return changed;
}

std::uint8_t ByteMap::At(Cell cell) const {
  const Tile* tile = tiles_.Find(TileOf(cell));
  return tile ? tile->cells[static_cast<std::size_t>(OffsetInTile(cell))] : kUnexploredByte;
}

bool ByteMap::Apply(const TileChange& change) {
  if (!tiles_.HasRoomFor(change.index) || !RunsFit(change.runs)) return false;
  if (change.runs.empty()) return true;
  return UnpackRuns(change.runs, tiles_.Touch(change.index).cells);
}

DenseGrid ByteMap::ToDenseGrid(double cell_size_m) const {
  DenseGrid grid;
  grid.cell_size_m = cell_size_m;
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
