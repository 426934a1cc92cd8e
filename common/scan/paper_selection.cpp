#include "common/scan/paper_selection.hpp"

#include <algorithm>

#include "common/scan/ray_selection.hpp"
#include "common/scan/segmented_scan.hpp"

namespace crsm {

std::vector<int> PaperSelection::operator()(const ValidRays& rays) {
  if (rays.size() < 2) return SelectAll(rays.size());
  const SegmentedScan scan(rays, ComputeDisplacements(rays), constants_.edge_threshold_m);
  const std::vector<int> critical = scan.Select(density_scale_, constants_.gap_threshold_rays);
  if (critical.size() > constants_.rays_max) density_scale_ *= constants_.step;
  if (critical.size() < constants_.rays_min) density_scale_ /= constants_.step;
  density_scale_ = std::clamp(density_scale_, constants_.density_scale_min, constants_.density_scale_max);
  return critical;
}

}  // namespace crsm
