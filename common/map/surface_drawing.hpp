#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/map/drawing_constants.hpp"
#include "common/map/scan_drawing.hpp"
#include "common/map/scan_on_map.hpp"
#include "common/map/tile_canvas.hpp"

namespace crsm {

/// Draws hits between the centres of cells, and the surfaces between neighbouring hits; what stood behind them fades.
class SurfaceDrawing : public ScanDrawing {
 public:
  explicit SurfaceDrawing(const DrawingConstants& constants = {});
  BlendIntensity Draw(const ScanOnMap& scan, TileCanvas& canvas) const override;

 private:
  void MarkBehind(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells, double cell_size_m,
                  TileCanvas& canvas) const;
  void MarkSurface(const Eigen::Vector2d& from_cells, const Eigen::Vector2d& to_cells, TileCanvas& canvas) const;
  void MarkHit(const Eigen::Vector2d& at_cells, TileCanvas& canvas) const;

  DrawingConstants constants_;
  std::vector<std::array<std::uint8_t, 4>> hit_marks_;  ///< by where between the centres of four cells a hit lies
};

}  // namespace crsm
