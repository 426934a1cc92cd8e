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

inline constexpr int kTileSide = 64;                      ///< cells
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
inline TileIndex TileOf(Cell cell) { return {cell.x >> 6, cell.y >> 6}; }
/// Where a cell lies in its tile: row by row from the lower left.
inline int OffsetInTile(Cell cell) { return (cell.y & 63) * kTileSide + (cell.x & 63); }

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

  /// The tiles of a rectangle row by row, with one more column and row of absent tiles: who looks beyond the rectangle
  /// comes to those by limiting the column to `width` and the row to `height`, as unsigned numbers.
  struct Directory {
    Tile* const* tiles;  ///< (width + 1) x (height + 1)
    TileIndex origin;
    unsigned width;
    unsigned height;
  };

  /// absent: what stands for every tile that was not touched.
  explicit TileGrid(std::unique_ptr<Tile> absent = nullptr) : absent_(std::move(absent)), directory_{absent_.get()} {}

  /// The tile; where nothing was touched the absent one, by default nullptr.
  Tile* Find(TileIndex index) const {
    const auto column = std::min(static_cast<unsigned>(index.x - origin_.x), width_);
    const auto row = std::min(static_cast<unsigned>(index.y - origin_.y), height_);
    return directory_[std::size_t{row} * (width_ + 1) + column];
  }

  /// Whether the tile is there, or a map may have it besides those that it has.
  bool HasRoomFor(TileIndex index) const {
    if (!InMapLimits(index)) return false;
    if (entries_.empty() || Find(index) != absent_.get()) return true;
    const std::int64_t width = std::max(high_.x, index.x) - std::min(low_.x, index.x) + 1;
    const std::int64_t height = std::max(high_.y, index.y) - std::min(low_.y, index.y) + 1;
    return entries_.size() < kMostTiles && width * height <= kMostTilesInRectangle;
  }

  /// The tile, made now if need be. Throws std::out_of_range beyond the map's limits.
  Tile& Touch(TileIndex index) {
    if (Tile* tile = Find(index); tile != absent_.get()) return *tile;
    if (!InMapLimits(index)) throw std::out_of_range("TileGrid: a tile beyond the limits of the map");
    GrowTo(index);
    low_ = {std::min(low_.x, index.x), std::min(low_.y, index.y)};
    high_ = {std::max(high_.x, index.x), std::max(high_.y, index.y)};
    entries_.push_back({index, std::make_unique<Tile>()});
    return *(Slot(index) = entries_.back().tile.get());
  }

  /// All tiles in the order in which they were made.
  const std::vector<Entry>& entries() const { return entries_; }

  /// For look-ups of many cells at a time. Valid until the next Touch.
  Directory directory() const { return {directory_.data(), origin_, width_, height_}; }

 private:
  Tile*& Slot(TileIndex index) {
    return directory_[static_cast<std::size_t>(index.y - origin_.y) * (width_ + 1) +
                      static_cast<std::size_t>(index.x - origin_.x)];
  }

  void GrowTo(TileIndex index) {
    if (static_cast<unsigned>(index.x - origin_.x) < width_ && static_cast<unsigned>(index.y - origin_.y) < height_)
      return;
    // Room ahead in steps of eight, so that a straight drive does not rebuild the directory at every tile.
    const auto Down = [](int value) { return value & ~7; };
    const auto Up = [](int value) { return (value | 7) + 1; };
    const bool empty = width_ == 0;
    const TileIndex low{Down(empty ? index.x : std::min(origin_.x, index.x)),
                        Down(empty ? index.y : std::min(origin_.y, index.y))};
    const TileIndex high{empty ? Up(index.x) : std::max(origin_.x + static_cast<int>(width_), Up(index.x)),
                         empty ? Up(index.y) : std::max(origin_.y + static_cast<int>(height_), Up(index.y))};
    origin_ = low;
    width_ = static_cast<unsigned>(high.x - low.x);
    height_ = static_cast<unsigned>(high.y - low.y);
    directory_.assign(std::size_t{width_ + 1} * (height_ + 1), absent_.get());
    for (const Entry& entry : entries_) Slot(entry.index) = entry.tile.get();
  }

  std::unique_ptr<Tile> absent_;
  TileIndex low_{kMaxTile, kMaxTile};  ///< the rectangle around all tiles, both ends included
  TileIndex high_{-kMaxTile - 1, -kMaxTile - 1};
  TileIndex origin_;
  unsigned width_ = 0;
  unsigned height_ = 0;
  std::vector<Tile*> directory_;
  std::vector<Entry> entries_;
};

}  // namespace crsm
