#pragma once

#include "common/math/pose2.hpp"

namespace crsm {

const Pose2 kTop{0.21, -0.33, 0.14};

/// A round hill around `top`, as high as `height`.
inline double Hill(const Pose2& pose, const Pose2& top, double height) {
  const double dx_m = pose.x_m - top.x_m;
  const double dy_m = pose.y_m - top.y_m;
  const double dyaw_rad = pose.yaw_rad - top.yaw_rad;
  return height - 10.0 * (dx_m * dx_m + dy_m * dy_m + dyaw_rad * dyaw_rad);
}

inline double OneHill(const Pose2& pose) { return Hill(pose, kTop, 1.0); }

}  // namespace crsm
