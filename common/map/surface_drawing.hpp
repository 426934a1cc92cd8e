#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/map/scan_drawing.hpp"
#include "common/scan/surface.hpp"

namespace crsm {

/// What the drawing of scans takes for granted. Source: chosen on aces, intel and simulated buildings, and checked on
/// fr079, killian and other seeds.
struct DrawingConstants {
  double occupied_density = 6.0;  ///< Dens_occu: how many times stronger an occupied cell is updated than a free one
  double intensity_min = 0.04;    ///< of the update: it follows the scan's mean sparseness within these
  double intensity_max = 0.2;
  double intensity_limit = 0.95;  ///< asymptotic: no cell is ever certain
  double first_intensity = 0.85;  ///< of a cell's first update, at least
  double erase_behind_m = 0.1;    ///< where hits are, behind them: what was drawn there fades
  double hit_spread = 2.5;        ///< how much of the cells around it a hit occupies, times its bilinear weight
  double join_max_m = 2.0;        ///< hits further apart than this are never joined
  double near_hits_cells = 2.0;   ///< hits this close are neighbours in the map whatever they lie on
  double step_cells = 0.25;       ///< along a surface: no cell on the way gets less than 3/4 of its share
  SurfaceConstants surface = {};
};

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
