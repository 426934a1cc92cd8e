#pragma once

#include <cmath>
#include <cstdlib>

#include "services/wire/wire.hpp"

namespace crsm {

/// A pose that hangs on others is as far away as these are together, further than a message may say; but it is a
/// number.
inline void Tame(pose2_t& pose) {
  if (!std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) || !(std::abs(pose.yaw_rad) < 6.3)) std::abort();
  if (std::abs(pose.x_m) > 1e6 || std::abs(pose.y_m) > 1e6) pose = {};
}

}  // namespace crsm
