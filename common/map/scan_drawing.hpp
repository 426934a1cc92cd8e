#pragma once

#include <Eigen/Core>

#include "common/map/blend_cells.hpp"
#include "common/map/tile_canvas.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// A scan where it is drawn.
struct ScanOnMap {
  const ValidRays& rays;
  const Eigen::Matrix2Xd& hits_m;  ///< laser frame
  Eigen::Matrix2Xd hits_cells;     ///< map frame
  Eigen::Vector2d laser_cells;     ///< map frame
  double cell_size_m;
};

/// How a scan changes the cells that it touches. Source: section 6.
class ScanDrawing {
 public:
  virtual ~ScanDrawing() = default;

  /// Marks the cells that a scan touches, and says how far these move.
  virtual BlendIntensity Draw(const ScanOnMap& scan, TileCanvas& canvas) const = 0;
};

}  // namespace crsm
