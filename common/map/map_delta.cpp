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

/// From a cell on, past cells that all differ: eight of them at a time, as long as there are eight.
int SkipChanges(const TileBytes& before, const TileBytes& after, int cell) {
  constexpr int kAtOnce = 8;
  constexpr std::uint64_t kLowBits = 0x0101010101010101;
  for (; cell + kAtOnce <= kTileCells; cell += kAtOnce) {
    std::uint64_t a, b;
    std::memcpy(&a, before.data() + cell, kAtOnce);
    std::memcpy(&b, after.data() + cell, kAtOnce);
    const std::uint64_t differs = a ^ b;
    if (((differs - kLowBits) & ~differs & kLowBits << 7) != 0) break;  // one of the bytes is 0
  }
  return cell;
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
  std::array<std::uint8_t, kMaxRunBytes> runs;
  auto* to = runs.data();
  const auto PushTwoBytes = [&](int value) {
    *to++ = static_cast<std::uint8_t>(value >> 8);
    *to++ = static_cast<std::uint8_t>(value & 0xff);
  };
  int end_of_last = 0;
  for (int cell = FindChange(before, after, 0); cell < kTileCells;) {
    int end;
    int next = cell;
    do {
      end = SkipChanges(before, after, next + 1);
      next = FindChange(before, after, end);
    } while (next < kTileCells && next - end <= kMaxGap);
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

}  // namespace crsm
