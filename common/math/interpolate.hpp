#pragma once

#include "common/math/pose2.hpp"

namespace crsm {

/// A pose on the way from one to another, which is straight in the frame of the first, and even. share: of the way, 0
/// to 1.
inline Pose2 Interpolate(const Pose2& from, const Pose2& to, double share) {
  const Pose2 motion = Inverse(from) * to;
  return from * Pose2{share * motion.x_m, share * motion.y_m, share * motion.yaw_rad};
}

}  // namespace crsm
