#include "common/map/map_delta.hpp"

#include <algorithm>

namespace crsm {
namespace {

constexpr int kMaxGap = 4;  // cells; as long as the header of a new run

void PushTwoBytes(std::vector<std::uint8_t>& bytes, int value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value & 0xff));
}

}  // namespace

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

std::vector<std::uint8_t> PackRuns(const TileBytes& before, const TileBytes& after) {
  std::vector<std::uint8_t> runs;
  const auto Differ = [&](int cell) {
    return before[static_cast<std::size_t>(cell)] != after[static_cast<std::size_t>(cell)];
  };
  int end_of_last = 0;
  for (int cell = 0; cell < kTileCells; ++cell) {
    if (!Differ(cell)) continue;
    int end = cell + 1;
    for (int next = end; next < kTileCells && next - end <= kMaxGap; ++next) {
      if (Differ(next)) end = next + 1;
    }
    PushTwoBytes(runs, cell - end_of_last);
    PushTwoBytes(runs, end - cell);
    runs.insert(runs.end(), after.begin() + cell, after.begin() + end);
    end_of_last = end;
    cell = end - 1;
  }
  return runs;
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

}  // namespace crsm
