#pragma once

#include "common/map/drawing_constants.hpp"
#include "common/map/scan_drawing.hpp"

namespace crsm {

/// Draws scans as the text of the paper does: the cells on a ray become freer, the one in which it ends fuller.
class PaperDrawing : public ScanDrawing {
 public:
  explicit PaperDrawing(const PaperDrawingConstants& constants = {}) : constants_(constants) {}
  BlendIntensity Draw(const ScanOnMap& scan, TileCanvas& canvas) const override;

 private:
  PaperDrawingConstants constants_;
};

}  // namespace crsm
