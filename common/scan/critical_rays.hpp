#pragma once

#include <cstdint>
#include <vector>

#include "common/scan/valid_rays.hpp"

namespace crsm {

/// What is left of a scan once it is known which of its beams measured something: all that is matched and drawn.
struct CriticalRays {
  std::int64_t utime = 0;     ///< the scan's
  ValidRays rays;             ///< every measurement
  std::vector<int> critical;  ///< indices of those that are matched, rising, no repeats

  friend bool operator==(const CriticalRays&, const CriticalRays&) = default;
};

}  // namespace crsm
