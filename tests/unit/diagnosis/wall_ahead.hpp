#pragma once

#include "common/map/byte_map.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// A wall across x = 2 m, in cells of 0.1 m, that rays from the origin see.
inline ByteMap MakeWall() {
  ByteMap map(0.1);
  for (int y = -40; y < 40; ++y) {
    for (int x = -5; x < 20; ++x) map.Set({x, y}, kFreeByte);
    map.Set({20, y}, kOccupiedByte);
  }
  return map;
}

inline ValidRays LookAhead(float range_m) {
  ValidRays rays;
  for (int i = -10; i <= 10; ++i) {
    rays.angle_rad.push_back(0.01f * static_cast<float>(i));
    rays.range_m.push_back(range_m);
  }
  return rays;
}

}  // namespace crsm
