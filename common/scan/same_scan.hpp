#pragma once

#include <cstring>

#include "common/scan/laser_scan.hpp"

namespace crsm {

/// Whether a scan is another one that was sent again. Bytes are compared, not numbers: NaN is no return as well.
inline bool IsSameScan(const LaserScan& a, const LaserScan& b) {
  return a.utime == b.utime && a.ranges_m.size() == b.ranges_m.size() &&
         std::memcmp(a.ranges_m.data(), b.ranges_m.data(), a.ranges_m.size() * sizeof(float)) == 0;
}

}  // namespace crsm
