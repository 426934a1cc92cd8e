#pragma once

#include <Eigen/Core>

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

}  // namespace crsm
