#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "common/parameters.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/paper_selection.hpp"
#include "common/scan/ray_selection.hpp"

namespace crsm {

/// Picks the critical rays among the valid ones of a scan, as indices, rising, no repeats.
using SelectCritical = std::function<std::vector<int>(const ValidRays&)>;

/// Ours, or that of the paper.
inline SelectCritical DefaultSelection(const Parameters& parameters, const SelectionConstants& constants = {}) {
  if (parameters.update.algorithm == Algorithm::kPaper) return PaperSelection();
  return [rays_max = parameters.selection.rays_max, constants](const ValidRays& rays) {
    return SelectRays(rays, rays_max, constants);
  };
}

/// From a scan to its critical rays.
class RaySelector {
 public:
  explicit RaySelector(const Parameters& parameters) : RaySelector(parameters.scan, DefaultSelection(parameters)) {}
  RaySelector(const ScanParameters& scan, SelectCritical select, const ValidRayConstants& constants = {})
      : scan_(scan), select_(std::move(select)), constants_(constants) {}

  /// Finds the measurements of a scan and picks the critical ones among them.
  CriticalRays Select(const LaserScan& scan) {
    CriticalRays selected{scan.utime, FindValidRays(scan, scan_, constants_), {}};
    selected.critical = select_(selected.rays);
    return selected;
  }

 private:
  ScanParameters scan_;
  SelectCritical select_;
  ValidRayConstants constants_;
};

}  // namespace crsm
