#pragma once

#include <vector>

#include "common/parameters.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// The critical rays of a scan and how they came about.
struct RaySelection {
  std::vector<int> critical;   ///< indices into the valid rays, rising, no repeats
  double density_scale = 0.0;  ///< the P that picked them; 0 where the method has none
};

inline constexpr double kFirstDensityScale = 100.0;  ///< P of the first scan, section 4.3

/// Picks the critical rays by the method that the parameters name; any number of rays, also none.
///
/// The segments method keeps the number of rays in [rays_min, rays_max]; where a scan has more rays than rays_max gaps
/// of gap_threshold_rays take, its gaps are as much wider as that needs. In mode `scan` it finds P for this scan alone
/// and keeps no state. In mode `previous`, which is the paper's, it uses `density_scale`; see NextDensityScale.
/// Source: section 4.
RaySelection SelectRays(const ValidRays& rays, const SelectionParameters& parameters,
                        double density_scale = kFirstDensityScale);

/// The P for the next scan: larger after too many rays, smaller after too few (section 4.3).
double NextDensityScale(double density_scale, std::size_t num_critical, const SelectionParameters& parameters);

}  // namespace crsm
