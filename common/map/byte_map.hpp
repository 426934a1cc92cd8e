#pragma once

#include <cstdint>
#include <span>

#include "common/map/dense_grid.hpp"
#include "common/map/map_delta.hpp"
#include "common/map/map_geometry.hpp"
#include "common/map/tile_grid.hpp"

namespace crsm {

/// The map as it travels: cells of a known size, one byte each: 255 free .. 0 occupied, 127 unexplored. What matcher
/// and exporter hold.
class ByteMap {
 public:
  struct Tile {
    TileBytes cells = kUnexploredBytes;
  };

  /// cell_size_m: > 0.
  explicit ByteMap(double cell_size_m) : geometry_(cell_size_m) {}

  const MapGeometry& geometry() const { return geometry_; }

  /// 127 where nothing was explored.
  std::uint8_t At(Cell cell) const;

  /// False, with nothing changed, if the cell is beyond the limits of the map, or the map has no room for its tile.
  bool Set(Cell cell, std::uint8_t byte);

  /// Applies one tile's change. A tile in which nothing is explored any more is no longer there. False, with nothing
  /// changed, if it is malformed, beyond the limits of the map, or if the map has no room for the tile.
  bool Apply(const TileChange& change);

  /// The same of many. Calls `applied` with each that could be applied; whether all could.
  template <class Applied>
  bool Apply(std::span<const TileChange> changes, Applied&& applied) {
    bool all_applied = true;
    for (const TileChange& change : changes) {
      if (Apply(change)) {
        applied(change);
      } else {
        all_applied = false;
      }
    }
    return all_applied;
  }

  bool empty() const { return tiles_.entries().empty(); }
  const TileGrid<Tile>& tiles() const { return tiles_; }

  /// Around all tiles; its low end is beyond its high one if there are none.
  CellRectangle FindTiled() const;

  /// The explored cells and the rectangle around them; empty (0 x 0) while nothing is explored. 2^28 cells at most.
  DenseGrid ToDenseGrid() const;

 private:
  CellRectangle FindExplored() const;

  MapGeometry geometry_;
  TileGrid<Tile> tiles_;
};

}  // namespace crsm
