#pragma once

#include "common/math/pose2.hpp"

namespace crsm {

struct Point {
  double x_m = 0.0;
  double y_m = 0.0;
  friend bool operator==(const Point&, const Point&) = default;
};

/// A point of frame b in frame a.
inline Point Apply(const Pose2& T_a_b, const Point& in_b) {
  const Pose2 in_a = T_a_b * Pose2{in_b.x_m, in_b.y_m, 0.0};
  return {in_a.x_m, in_a.y_m};
}

}  // namespace crsm
