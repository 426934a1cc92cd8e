#pragma once

#include <vector>

#include "common/scan/valid_rays.hpp"

namespace crsm {

/// A scan cut into segments at its edges, from which rays are picked. Source: section 4.3 and its pseudo-code.
class SegmentedScan {
 public:
  /// rays: two or more. displacements: RaysDisplacement of Eq. 2, the distance between neighbouring hits [m].
  /// edge_threshold_m: D_THRES, a larger one is an edge.
  SegmentedScan(const ValidRays& rays, std::vector<double> displacements, double edge_threshold_m);

  /// The rays that are picked with a density scale P, as indices into the rays, rising. gap_threshold_rays: RAY_THRES,
  /// at most so far apart are two of them.
  std::vector<int> Select(double density_scale, int gap_threshold_rays) const;

  /// How many rays edges and gaps alone pick.
  std::size_t CountEdgesAndGaps(int gap_threshold_rays) const;

 private:
  std::vector<double> displacements_;
  std::vector<int> edges_;            ///< FeatureEdges; a segment lies between two of them
  std::vector<double> sparseness_m_;  ///< of segments
  std::vector<double> damping_;       ///< of rays: 1 / e^(S[i] / sqrt(Max))
};

}  // namespace crsm
