#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/map/dense_grid.hpp"
#include "common/map/tile_grid.hpp"

namespace crsm {

/// Changed cells of one tile, packed as they travel.
///
/// Runs of cells in row-major order from the tile's lower left: skip (2 bytes, high byte first), count (2 bytes, high
/// byte first, >= 1), then one byte a cell. Cells in no run keep their value.
struct TileChange {
  TileIndex index;
  std::vector<std::uint8_t> runs;
};

/// What one scan changed in the map: from version - 1 to version.
struct MapDelta {
  std::int64_t version = 0;
  bool drawn = false;  ///< the scan was drawn; else there are no changes
  std::vector<TileChange> tiles;
};

using TileBytes = std::array<std::uint8_t, kTileCells>;

/// Of a tile in which nothing was explored.
inline constexpr TileBytes kUnexploredBytes = [] {
  TileBytes bytes{};
  bytes.fill(kUnexploredByte);
  return bytes;
}();

/// No change of a tile packs into more than this: a gap of up to four cells is sent along, a run header being as long.
inline constexpr std::size_t kMaxRunBytes = kTileCells + 4;

/// Packs the cells in which `after` differs from `before`. Empty when there are none.
std::vector<std::uint8_t> PackRuns(const TileBytes& before, const TileBytes& after);

/// Whether runs are well-formed and stay within a tile.
bool RunsFit(std::span<const std::uint8_t> runs);

/// Unpacks runs onto the cells of a tile. False, with `cells` untouched, if they are malformed.
bool UnpackRuns(std::span<const std::uint8_t> runs, TileBytes& cells);

/// The rectangle around the cells that a change names; its runs are well-formed and not empty.
CellRectangle FindChangedCells(const TileChange& change);

}  // namespace crsm
