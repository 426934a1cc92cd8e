#include "common/map/tile_canvas.hpp"

#include <utility>

#include "common/map/dense_grid.hpp"
#include "common/map/scan_on_map.hpp"
#include "common/map/walk_cells.hpp"

namespace crsm {

TileCanvas::Cells::Cells() : bytes(kUnexploredBytes) { p_free.fill(0.5f); }

void TileCanvas::MarkFree(const ScanOnMap& scan) {
  constexpr Cell kNowhere{-2 * kMaxCell, kMaxCell};
  std::uint8_t* marks = nullptr;  // those of the tile in which the walk is ...
  Cell corner = kNowhere;         // ... and its first cell
  const auto IsInside = [](int right, int up) { return static_cast<unsigned>(right | up) < kTileSide; };
  const auto MarkOne = [&](Cell cell) {
    if (!IsInside(cell.x - corner.x, cell.y - corner.y)) {
      Tile* tile = MarkTile(TileOf(cell));
      marks = tile ? tile->cells->marks.data() : nullptr;
      corner = tile ? CellsOf(TileOf(cell)).low : kNowhere;
    }
    if (marks) marks[OffsetInTile(cell)] = kFreeMark;
  };
  const auto MarkTwo = [&](Cell cell, Cell next) {
    const Cell a{cell.x - corner.x, cell.y - corner.y};
    const Cell b{next.x - corner.x, next.y - corner.y};
    if (IsInside(a.x | b.x, a.y | b.y)) {
      marks[a.y * kTileSide + a.x] = kFreeMark;
      marks[b.y * kTileSide + b.x] = kFreeMark;
    } else {
      MarkOne(cell);
      MarkOne(next);
    }
  };
  for (Eigen::Index i = 0; i < scan.hits_cells.cols(); ++i) {
    WalkCells(scan.laser_cells, scan.hits_cells.col(i), MarkTwo);
  }
}

bool TileCanvas::IsExplored(Cell cell) const {
  const TileIndex index = TileOf(cell);
  const Tile* tile = marking_ && index == marking_index_ ? marking_ : tiles_.Find(index);
  return tile && tile->bytes()[static_cast<std::size_t>(OffsetInTile(cell))] != kUnexploredByte;
}

bool TileCanvas::Blend(const BlendIntensity& intensity, std::int64_t version, BytesBefore* before) {
  for (const TileIndex index : marked_) {
    Tile& tile = *tiles_.Find(index);
    if (before) before->try_emplace(index, tile.bytes());
    tile.marked = false;
    blend_(intensity, tile.cells->marks.data(), tile.cells->p_free.data(), tile.cells->bytes.data());
    if (!before) tile.changed_in_version = version;
  }
  marked_.clear();
  marking_ = nullptr;
  return !std::exchange(cut_, false);
}

/// The tile, on the list of those that the scan touches; nullptr if there is no room for it.
TileCanvas::Tile* TileCanvas::MarkTile(TileIndex index) {
  Tile* tile = tiles_.Find(index);
  if (!tile && tiles_.HasRoomFor(index)) tile = &tiles_.Touch(index);
  if (!tile) {
    cut_ = true;
  } else if (!std::exchange(tile->marked, true)) {
    if (!tile->cells) tile->cells = std::make_unique<Cells>();
    marked_.push_back(index);
  }
  return tile;
}

}  // namespace crsm
