#pragma once

#include "common/map/blend_cells.hpp"

namespace crsm {

class TileCanvas;
struct ScanOnMap;

/// How a scan changes the cells that it touches. Source: section 6.
class ScanDrawing {
 public:
  virtual ~ScanDrawing() = default;

  /// Marks the cells that a scan touches, and says how far these move.
  virtual BlendIntensity Draw(const ScanOnMap& scan, TileCanvas& canvas) const = 0;
};

}  // namespace crsm
