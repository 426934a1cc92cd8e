#pragma once

#include "common/math/pose2.hpp"
#include "common/math/random.hpp"

namespace crsm {

/// Bounds of a random change of the genome [Dx, Dy, Dtheta]. Source: section 5.1.
struct MotionBounds {
  double x_m;  ///< and y
  double yaw_rad;

  friend MotionBounds operator*(double factor, const MotionBounds& bounds) {
    return {factor * bounds.x_m, factor * bounds.yaw_rad};
  }
};

/// A random pose around another.
inline Pose2 Mutate(const Pose2& pose, const MotionBounds& bounds, Random& random) {
  const double dx_m = random.Uniform(-bounds.x_m, bounds.x_m);
  const double dy_m = random.Uniform(-bounds.x_m, bounds.x_m);
  const double dyaw_rad = random.Uniform(-bounds.yaw_rad, bounds.yaw_rad);
  return {pose.x_m + dx_m, pose.y_m + dy_m, pose.yaw_rad + dyaw_rad};
}

}  // namespace crsm
