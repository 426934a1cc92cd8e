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
  std::vector<TileChange> tiles;
};

using TileBytes = std::array<std::uint8_t, kTileCells>;

/// No change of a tile packs into more than this: a gap of up to four cells is sent along, a run header being as long.
inline constexpr std::size_t kMaxRunBytes = kTileCells + 4;

/// Packs the cells in which `after` differs from `before`. Empty when there are none.
std::vector<std::uint8_t> PackRuns(const TileBytes& before, const TileBytes& after);

/// Unpacks runs onto the cells of a tile. False, with `cells` untouched, if they are malformed.
bool UnpackRuns(std::span<const std::uint8_t> runs, TileBytes& cells);

/// The rectangle around the cells that a change names; its runs are well-formed and not empty.
CellRectangle FindChangedCells(const TileChange& change);

/// The map as it travels: one byte a cell, 255 free .. 0 occupied, 127 unexplored. What matcher and exporter hold.
class ByteMap {
 public:
  struct Tile {
    TileBytes cells;
    Tile() { cells.fill(kUnexploredByte); }
  };

  /// 127 where nothing was explored.
  std::uint8_t At(Cell cell) const;

  /// Applies one tile's change. False, with nothing changed, if it is malformed, beyond the limits of the map, or if
  /// the map has no room for the tile.
  bool Apply(const TileChange& change);

  const TileGrid<Tile>& tiles() const { return tiles_; }

  /// The explored cells and the rectangle around them; empty (0 x 0) while nothing is explored. 2^28 cells at most.
  DenseGrid ToDenseGrid(double cell_size_m) const;

 private:
  TileGrid<Tile> tiles_;
};

}  // namespace crsm
