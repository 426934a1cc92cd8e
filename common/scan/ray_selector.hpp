#pragma once

#include "common/parameters.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/ray_selection.hpp"

namespace crsm {

/// From a scan to its critical rays. What picks other rays is another class with the same `Select`.
class RaySelector {
 public:
  explicit RaySelector(const Parameters& parameters) : scan_(parameters.scan), selection_(parameters.selection) {}

  /// Finds the measurements of a scan and picks the critical ones among them. The result depends on the scan alone,
  /// but in the mode in which the density scale P follows the scan before (section 4.3).
  CriticalRays Select(const LaserScan& scan) {
    CriticalRays selected{scan.utime, FindValidRays(scan, scan_), {}};
    selected.critical = SelectRays(selected.rays, selection_, density_scale_).critical;
    density_scale_ = NextDensityScale(density_scale_, selected.critical.size(), selection_);
    return selected;
  }

 private:
  ScanParameters scan_;
  SelectionParameters selection_;
  double density_scale_ = kFirstDensityScale;
};

}  // namespace crsm
