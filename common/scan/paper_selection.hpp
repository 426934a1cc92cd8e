#pragma once

#include <cstddef>
#include <vector>

#include "common/scan/valid_rays.hpp"

namespace crsm {

/// What the text of the paper leaves open, or gives a number for. Source: section 4.3.
struct PaperSelectionConstants {
  double edge_threshold_m = 0.5;  ///< D_THRES: the paper gives no number
  int gap_threshold_rays = 25;    ///< RAY_THRES: the paper gives no number
  std::size_t rays_min = 30;
  std::size_t rays_max = 50;
  double first_density_scale = 100.0;  ///< P of the first scan
  double step = 1.1;  ///< of P from scan to scan: the paper gives no rate; a tenth settles within some scans
  double density_scale_min = 1e-3;
  double density_scale_max = 1e6;
};

/// Picks critical rays as the text of the paper does: the density scale P is larger after too many rays, and smaller
/// after too few.
class PaperSelection {
 public:
  explicit PaperSelection(const PaperSelectionConstants& constants = {})
      : constants_(constants), density_scale_(constants.first_density_scale) {}

  /// Of one scan after the other; indices into the valid rays, rising, no repeats.
  std::vector<int> operator()(const ValidRays& rays);

 private:
  PaperSelectionConstants constants_;
  double density_scale_;  ///< P
};

}  // namespace crsm
