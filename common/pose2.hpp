#pragma once

#include "common/trigonometry.hpp"

namespace crsm {

/// A pose in the plane, or the motion between two of them: `T_a_b` is frame b seen from frame a.
struct Pose2 {
  double x_m = 0.0;
  double y_m = 0.0;
  double yaw_rad = 0.0;  ///< counter-clockwise

  friend bool operator==(const Pose2&, const Pose2&) = default;
};

/// T_a_c = T_a_b * T_b_c.
inline Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c) {
  const auto [sin, cos] = ComputeSinCos(T_a_b.yaw_rad);
  return {T_a_b.x_m + cos * T_b_c.x_m - sin * T_b_c.y_m, T_a_b.y_m + sin * T_b_c.x_m + cos * T_b_c.y_m,
          WrapAngle(T_a_b.yaw_rad + T_b_c.yaw_rad)};
}

/// T_b_a from T_a_b.
inline Pose2 Inverse(const Pose2& T_a_b) {
  const auto [sin, cos] = ComputeSinCos(T_a_b.yaw_rad);
  return {-cos * T_a_b.x_m - sin * T_a_b.y_m, sin * T_a_b.x_m - cos * T_a_b.y_m, -T_a_b.yaw_rad};
}

}  // namespace crsm
