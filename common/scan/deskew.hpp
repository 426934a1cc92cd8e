#pragma once

#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// A sweep as it would have been measured at once, at the scan's utime, by a laser that moved like that in the
/// meantime: each ray goes from where the laser stood in the end to where it hit. Angles rise, also where the ends of a
/// full turn have come to overlap; the critical rays are the same ones. Rays without times stay as they are.
CriticalRays Deskew(const CriticalRays& scan, const Twist& twist);

/// The same of rays alone.
ValidRays Deskew(const ValidRays& rays, const Twist& twist);

}  // namespace crsm
