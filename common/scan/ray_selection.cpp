#include "common/scan/ray_selection.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "common/scan/segmented_scan.hpp"

namespace crsm {
namespace {

/// D_THRES; larger where the scan has so many edges that too little would be left for the surfaces between them.
double FindEdgeThreshold(std::vector<double> displacements, int rays_max, const SelectionConstants& constants) {
  const auto most_edges = static_cast<std::size_t>(constants.most_on_edges * rays_max / 2.0);  // each picks two rays
  if (displacements.size() <= most_edges) return constants.edge_threshold_m;
  const auto nth = displacements.begin() + static_cast<std::ptrdiff_t>(most_edges);
  std::nth_element(displacements.begin(), nth, displacements.end(), std::greater<>());
  return std::max(constants.edge_threshold_m, *nth);
}

/// RAY_THRES; of a scan with so many rays that they make more than rays_max of such gaps the next larger one with which
/// edges and gaps alone do not pick more.
int FindGapThreshold(const SegmentedScan& scan, int num_rays, int rays_max, int least) {
  if (2 * num_rays <= least * rays_max) return least;  // a gap that is halved leaves two of half its width
  int low = least;
  int high = num_rays;  // no gap is as wide
  while (low < high) {
    const int middle = (low + high) / 2;
    if (scan.CountEdgesAndGaps(middle) > static_cast<std::size_t>(rays_max)) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

}  // namespace

std::vector<int> SelectAll(std::size_t num_rays) {
  std::vector<int> picked(num_rays);
  std::iota(picked.begin(), picked.end(), 0);
  return picked;
}

std::vector<int> SelectRays(const ValidRays& rays, int rays_max, const SelectionConstants& constants) {
  if (rays.size() < 2) return SelectAll(rays.size());
  std::vector<double> displacements = ComputeDisplacements(rays);
  const double edge_threshold_m = FindEdgeThreshold(displacements, rays_max, constants);
  const SegmentedScan scan(rays, std::move(displacements), edge_threshold_m);
  const int gap_rays = FindGapThreshold(scan, static_cast<int>(rays.size()), rays_max, constants.gap_threshold_rays);
  const auto most = static_cast<std::size_t>(rays_max);
  const auto fewest = static_cast<std::size_t>(std::lround(constants.fewest * rays_max));
  double low = constants.density_scale_min;
  double high = constants.density_scale_max;
  std::vector<int> critical;
  for (int halving = 0; halving < constants.halvings; ++halving) {  // the count falls as P rises
    const double density_scale = std::sqrt(low * high);
    critical = scan.Select(density_scale, gap_rays);
    if (critical.size() > most) {
      low = density_scale;
    } else if (critical.size() < fewest) {
      high = density_scale;
    } else {
      break;
    }
  }
  return critical;
}

}  // namespace crsm
