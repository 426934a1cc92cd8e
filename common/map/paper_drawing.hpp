#pragma once

#include "common/map/scan_drawing.hpp"

namespace crsm {

/// What the text of the paper leaves open. Source: section 6.
struct PaperDrawingConstants {
  double occupied_density = 2.0;  ///< Dens_occu > 1: the paper gives no number
  double intensity_min = 0.0;     ///< "proportionate to the mean sparseness"
  double intensity_max = 1.0;
  double intensity_limit = 0.95;  ///< asymptotic: no cell is ever certain
};

/// Draws scans as the text of the paper does: the cells on a ray become freer, the one in which it ends fuller.
class PaperDrawing : public ScanDrawing {
 public:
  explicit PaperDrawing(const PaperDrawingConstants& constants = {}) : constants_(constants) {}
  BlendIntensity Draw(const ScanOnMap& scan, TileCanvas& canvas) const override;

 private:
  PaperDrawingConstants constants_;
};

}  // namespace crsm
