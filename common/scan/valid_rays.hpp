#pragma once

#include <vector>

#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// Which beams count as measurements.
struct ValidRayConstants {
  double usable_share = 0.95;  ///< of the laser's maximum range: section 4, "for safety reasons"
};

/// The measurements of a scan, in order of rising angle.
struct ValidRays {
  std::vector<float> angle_rad;  ///< laser frame, counter-clockwise from x
  std::vector<float> range_m;    ///< > 0
  /// When each was measured, after the scan's utime [s], negative before it; empty: all at once.
  std::vector<float> time_s = {};

  std::size_t size() const { return range_m.size(); }
  friend bool operator==(const ValidRays&, const ValidRays&) = default;
};

/// 95 % of the laser's maximum range [m]: what reads further has not measured anything (section 4).
double LargestUsableRange(const ScanParameters& parameters, const ValidRayConstants& constants = {});

/// Keeps the beams that measured something: finite, at least `range_min_m`, and at most 95 % of the laser's maximum
/// range (section 4), at their angles times `angle_scale`. Descending scans are turned round. An empty scan gives no
/// rays. Where the scan does not say when its beams were measured, the last one was at its utime, and the first one
/// `sweep_s` before.
ValidRays FindValidRays(const LaserScan& scan, const ScanParameters& parameters,
                        const ValidRayConstants& constants = {});

/// Distance from each hit to the next [m], N - 1 of them, by the cosine law in the triangle with the laser (Eq. 2).
/// The angle is the true one between the two rays, which is larger where beams between them were discarded.
std::vector<double> ComputeDisplacements(const ValidRays& rays);

/// Mean distance between neighbouring hits [m]; 0 with fewer than two rays.
double ComputeMeanSparseness(const ValidRays& rays);

}  // namespace crsm
