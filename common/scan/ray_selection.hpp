#pragma once

#include <vector>

#include "common/scan/valid_rays.hpp"

namespace crsm {

/// What the selection of critical rays takes for granted.
struct SelectionConstants {
  double edge_threshold_m = 0.5;  ///< D_THRES: the paper gives no number
  int gap_threshold_rays = 10;    ///< RAY_THRES: the paper gives no number
  double fewest = 2.0 / 3.0;      ///< rays, of the most
  double most_on_edges = 0.5;     ///< of the most rays: the others are for the surfaces between edges
  double density_scale_min = 1e-3;
  double density_scale_max = 1e6;
  int halvings = 24;  ///< of the density scale's logarithm, until the count is in its band
  ValidRayConstants valid_rays = {};
};

/// Picks the critical rays of a scan, as indices into the valid rays, rising, no repeats. Keeps no state.
///
/// rays: any number, also none. rays_max: the most to pick; the fewest are two thirds of them, where the scan has so
/// many. The edges that pick rays are the widest; where a scan has more rays than rays_max gaps take, its gaps are as
/// much wider as that needs. The density scale P is found for this scan alone.
/// Source: section 4.3, where P follows the scans before; see paper_selection.hpp.
std::vector<int> SelectRays(const ValidRays& rays, int rays_max, const SelectionConstants& constants = {});

/// All rays: 0 to num_rays - 1.
std::vector<int> SelectAll(std::size_t num_rays);

}  // namespace crsm
