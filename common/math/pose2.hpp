#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/math/trigonometry.hpp"

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

/// How far a motion leads [m], the same on every machine.
inline double Length(const Pose2& motion) { return std::sqrt(motion.x_m * motion.x_m + motion.y_m * motion.y_m); }

/// As the crow flies [m], the same on every machine.
inline double Distance(const Pose2& a, const Pose2& b) { return Length({a.x_m - b.x_m, a.y_m - b.y_m, 0.0}); }

/// Whether two poses are nearly one. near_m, near_rad: what they differ by is less.
inline bool AreNear(const Pose2& a, const Pose2& b, double near_m, double near_rad) {
  const Pose2 error = Inverse(a) * b;
  return Length(error) < near_m && std::abs(error.yaw_rad) < near_rad;
}

/// A pose as odometry gives it, to whole micrometres and microradians; nothing where that is no pose: a number that is
/// none, or beyond 1e6. Rounded, a pose is the same to the last bit whether its heading comes as an angle, as in CARMEN
/// logs, or as a quaternion, as on the wire.
inline std::optional<Pose2> RoundOdometry(const Pose2& pose) {
  constexpr double kLargest = 1e6;
  const auto in_range = [](double value) { return std::abs(value) <= kLargest; };  // false for NaN
  if (!in_range(pose.x_m) || !in_range(pose.y_m) || !in_range(pose.yaw_rad)) return std::nullopt;
  const auto round = [](double value) { return std::round(value * 1e6) / 1e6 + 0.0; };  // + 0.0: never -0.0
  constexpr double kLargestYaw_rad = 3.141592;  // the largest that stays where it is when it is wrapped
  return Pose2{round(pose.x_m), round(pose.y_m),
               std::clamp(round(WrapAngle(pose.yaw_rad)), -kLargestYaw_rad, kLargestYaw_rad)};
}

}  // namespace crsm
