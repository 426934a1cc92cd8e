#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace crsm {

inline constexpr int kTileBits = 6;                       ///< a cell's coordinate, shifted by these, is its tile's ...
inline constexpr int kTileSide = 1 << kTileBits;          ///< cells
inline constexpr int kTileMask = kTileSide - 1;           ///< ... and masked by this, where in the tile it lies
inline constexpr int kTileCells = kTileSide * kTileSide;  ///< cells in a tile
inline constexpr int kMaxTile = 1024;                     ///< tiles run from -kMaxTile to kMaxTile - 1 on each axis
inline constexpr int kMaxCell = kMaxTile * kTileSide;     ///< and cells from -kMaxCell to kMaxCell - 1

// What a map may take of memory. With cells of 0.05 m: 0.17 km2 explored, in a rectangle of 0.67 km2.
inline constexpr std::size_t kMostTiles = std::size_t{1} << 14;
inline constexpr std::int64_t kMostTilesInRectangle = std::int64_t{1} << 16;  ///< around all tiles

/// A cell of the map. Cell (0, 0) has its lower left corner at the map's origin; x right, y up.
struct Cell {
  int x = 0;
  int y = 0;
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// Cells from `low` to `high`, both included.
struct CellRectangle {
  Cell low;
  Cell high;
  friend bool operator==(const CellRectangle&, const CellRectangle&) = default;
};

struct TileIndex {
  int x = 0;
  int y = 0;
  friend auto operator<=>(const TileIndex&, const TileIndex&) = default;
};

inline bool InMapLimits(Cell cell) {
  return cell.x >= -kMaxCell && cell.x < kMaxCell && cell.y >= -kMaxCell && cell.y < kMaxCell;
}
inline bool InMapLimits(TileIndex tile) {
  return tile.x >= -kMaxTile && tile.x < kMaxTile && tile.y >= -kMaxTile && tile.y < kMaxTile;
}
/// The tile of a cell. Right shifts of negative numbers round down (C++20).
inline TileIndex TileOf(Cell cell) { return {cell.x >> kTileBits, cell.y >> kTileBits}; }
/// Where a cell lies in its tile: row by row from the lower left.
inline int OffsetInTile(Cell cell) { return (cell.y & kTileMask) << kTileBits | (cell.x & kTileMask); }

/// The cell that lies there in the tile.
inline Cell CellAt(TileIndex tile, int offset) {
  return {tile.x * kTileSide + (offset & kTileMask), tile.y * kTileSide + (offset >> kTileBits)};
}

/// All cells of a tile.
inline CellRectangle CellsOf(TileIndex tile) { return {CellAt(tile, 0), CellAt(tile, kTileCells - 1)}; }

/// A rectangle of tiles, row by row, with one more column and row: that padding absorbs out-of-range look-ups.
struct TileRectangle {
  TileIndex origin;  ///< the lower left tile
  unsigned width = 0;
  unsigned height = 0;

  bool Contains(TileIndex index) const { return Column(index) < width && Row(index) < height; }
  std::size_t num_places() const { return std::size_t{width + 1} * (height + 1); }
  std::size_t Place(TileIndex index) const {
    return std::size_t{std::min(Row(index), height)} * (width + 1) + std::min(Column(index), width);
  }

  /// One that holds the tile too. A side that grows does so by half of it at least: what it costs to make a directory
  /// of the larger one is a constant for each tile, however far the map grows.
  TileRectangle GrownTo(TileIndex index) const {
    if (width == 0) return {index, 1, 1};
    TileRectangle grown = *this;
    Grow(grown.origin.x, grown.width, index.x);
    Grow(grown.origin.y, grown.height, index.y);
    return grown;
  }

 private:
  // As unsigned numbers, what is left of or below the rectangle is beyond its end.
  unsigned Column(TileIndex index) const { return static_cast<unsigned>(index.x - origin.x); }
  unsigned Row(TileIndex index) const { return static_cast<unsigned>(index.y - origin.y); }

  static void Grow(int& low, unsigned& size, int index) {
    constexpr int kLeast = 8;
    const int step = std::max(kLeast, static_cast<int>(size / 2));
    const int end = low + static_cast<int>(size);
    const int new_low = index < low ? std::min(index, low - step) : low;
    const int new_end = index >= end ? std::max(index + 1, end + step) : end;
    low = new_low;
    size = static_cast<unsigned>(new_end - new_low);
  }
};

/// Tiles of cells that come into being where they are first touched: memory follows the explored area, and the map
/// grows in any direction. A directory over the bounding box of the tiles makes a look-up two comparisons and a
/// load, whatever the map's size. Move-only.
template <class Tile>
class TileGrid {
 public:
  struct Entry {
    TileIndex index;
    std::unique_ptr<Tile> tile;
  };

  /// The tile; nullptr where nothing was touched.
  Tile* Find(TileIndex index) const { return directory_[rectangle_.Place(index)]; }

  /// Whether the tile is there, or a map may have it besides those that it has.
  bool HasRoomFor(TileIndex index) const {
    if (!InMapLimits(index)) return false;
    if (entries_.empty() || Find(index)) return true;
    const std::int64_t width = std::max(high_.x, index.x) - std::min(low_.x, index.x) + 1;
    const std::int64_t height = std::max(high_.y, index.y) - std::min(low_.y, index.y) + 1;
    return entries_.size() < kMostTiles && width * height <= kMostTilesInRectangle;
  }

  /// The tile, made now if need be. Throws std::out_of_range beyond the map's limits.
  Tile& Touch(TileIndex index) {
    if (Tile* tile = Find(index)) return *tile;
    if (!InMapLimits(index)) throw std::out_of_range("TileGrid: a tile beyond the limits of the map");
    if (!rectangle_.Contains(index)) {
      rectangle_ = rectangle_.GrownTo(index);
      directory_.assign(rectangle_.num_places(), nullptr);
      for (const Entry& entry : entries_) directory_[rectangle_.Place(entry.index)] = entry.tile.get();
    }
    low_ = {std::min(low_.x, index.x), std::min(low_.y, index.y)};
    high_ = {std::max(high_.x, index.x), std::max(high_.y, index.y)};
    entries_.push_back({index, std::make_unique<Tile>()});
    return *(directory_[rectangle_.Place(index)] = entries_.back().tile.get());
  }

  /// All tiles in the order in which they were made.
  const std::vector<Entry>& entries() const { return entries_; }

  /// Another tile in the place of one of them. entry: its number.
  void Replace(std::size_t entry, std::unique_ptr<Tile> tile) {
    directory_[rectangle_.Place(entries_[entry].index)] = tile.get();
    entries_[entry].tile = std::move(tile);
  }
  /// Takes a tile that is there away. Its place goes on to count for the rectangle around all tiles.
  void Remove(TileIndex index) {
    directory_[rectangle_.Place(index)] = nullptr;
    entries_.erase(std::ranges::find(entries_, index, &Entry::index));
  }
  std::vector<Entry> TakeEntries() && { return std::move(entries_); }

  /// Around all tiles, with room to grow.
  const TileRectangle& rectangle() const { return rectangle_; }

 private:
  TileIndex low_{kMaxTile, kMaxTile};  ///< the rectangle around all tiles, both ends included
  TileIndex high_{-kMaxTile - 1, -kMaxTile - 1};
  TileRectangle rectangle_;
  std::vector<Tile*> directory_{nullptr};  ///< num_places()
  std::vector<Entry> entries_;
};

}  // namespace crsm
