#pragma once

#include <cmath>

#include "common/math/pose2.hpp"

namespace crsm {

/// The motion of the laser as the wheels tell it, and how well: standard deviations, those of the position the same in
/// all directions.
struct WheelMotion {
  Pose2 T_from_to;
  double sigma_m = 0.0;
  double sigma_rad = 0.0;

  friend bool operator==(const WheelMotion&, const WheelMotion&) = default;

  /// One after the other: errors are independent, and an error of the first heading turns the second way.
  friend WheelMotion operator*(const WheelMotion& a, const WheelMotion& b) {
    const double swing_m = a.sigma_rad * Length(b.T_from_to);
    return {a.T_from_to * b.T_from_to, std::sqrt(a.sigma_m * a.sigma_m + b.sigma_m * b.sigma_m + swing_m * swing_m),
            std::sqrt(a.sigma_rad * a.sigma_rad + b.sigma_rad * b.sigma_rad)};
  }
};

}  // namespace crsm
