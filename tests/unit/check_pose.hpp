#pragma once

#include "catch.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

inline void CheckPose(const Pose2& pose, const Pose2& truth, double margin_m) {
  CHECK(pose.x_m == Approx(truth.x_m).margin(margin_m));
  CHECK(pose.y_m == Approx(truth.y_m).margin(margin_m));
  CHECK(pose.yaw_rad == Approx(truth.yaw_rad).margin(margin_m / 3.0));  // at the walls, 3 m away, it is as much
}

}  // namespace crsm
