#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "common/map/blend_cells.hpp"
#include "common/map/map_delta.hpp"
#include "common/map/tile_grid.hpp"

namespace crsm {

struct ScanOnMap;

using BytesBefore = std::map<TileIndex, TileBytes>;  ///< tiles that were drawn into, as they were

/// The cells that scans are drawn into: a scan marks the cells that it touches, then all of these are blended at once.
class TileCanvas {
 public:
  /// What it takes to draw into a tile.
  struct Cells {
    std::array<float, kTileCells> p_free;          ///< exact; the wire carries it rounded to a byte
    std::array<std::uint8_t, kTileCells> marks{};  ///< of the scan at hand
    TileBytes bytes;

    Cells();
  };

  struct Tile {
    std::unique_ptr<Cells> cells;  ///< nullptr where nothing is drawn, as in most once the path is long
    bool marked = false;           ///< by the scan at hand
    std::int64_t changed_in_version = 0;

    const TileBytes& bytes() const { return cells ? cells->bytes : kUnexploredBytes; }
  };

  TileCanvas() : blend_(FindBlendKernels().back()) {}

  /// Marks the cells on all rays of a scan as free. To be called before anything else is marked.
  void MarkFree(const ScanOnMap& scan);

  /// Each cell counts once a scan, by the largest share that an obstacle has in it.
  void Mark(Cell cell, std::uint8_t mark) {
    if (std::uint8_t* slot = FindMark(cell)) *slot = std::max(*slot, mark);
  }

  /// The mark of a cell; nullptr if there is no room for its tile.
  std::uint8_t* FindMark(Cell cell) {
    const TileIndex index = TileOf(cell);
    if (!marking_ || index != marking_index_) {
      marking_ = MarkTile(index);
      marking_index_ = index;
    }
    return marking_ ? &marking_->cells->marks[static_cast<std::size_t>(OffsetInTile(cell))] : nullptr;
  }

  bool IsExplored(Cell cell) const;

  /// The asymptotic rule of section 6 on every marked cell; the marks are cleared.
  /// before: tiles that are not in it yet are added; nullptr where nobody asks, then they have changed in `version`.
  /// False if there was no room for a part of the scan.
  bool Blend(const BlendIntensity& intensity, std::int64_t version, BytesBefore* before);

  TileGrid<Tile>& tiles() { return tiles_; }
  const TileGrid<Tile>& tiles() const { return tiles_; }

 private:
  Tile* MarkTile(TileIndex index);

  BlendKernel blend_;
  TileGrid<Tile> tiles_;
  std::vector<TileIndex> marked_;  ///< tiles that the scan at hand touches
  Tile* marking_ = nullptr;        ///< the one it touched last, nullptr if there is no room for it ...
  TileIndex marking_index_;        ///< ... and where that is
  bool cut_ = false;               ///< there was no room for all of it
};

}  // namespace crsm
