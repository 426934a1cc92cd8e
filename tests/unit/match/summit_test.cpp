#include "common/match/summit.hpp"

#include <algorithm>

#include "catch.hpp"
#include "check_pose.hpp"
#include "hill.hpp"

namespace crsm {
namespace {

/// Another hill, 0.6 m along an axis from the first.
const Eigen::Vector2d kAxis(0.8, -0.6);
const Pose2 kOther{kTop.x_m + 0.6 * kAxis.x(), kTop.y_m + 0.6 * kAxis.y(), kTop.yaw_rad};

}  // namespace

TEST_CASE("a climb by halving steps ends within the last of them of the summit") {
  const ScoredPose top = ClimbToSummit({0.3, -0.2, 0.1}, 0.05, 0.01, 6, OneHill);
  CheckPose(top.pose, kTop, 0.001);
  CHECK(top.fitness == OneHill(top.pose));
}

TEST_CASE("the yaw goes to the middle of its summit, and not beyond the width, nor from a plain") {
  const auto Centred = [](double fitness_to_left, double fitness_to_right) {
    const auto Sides = [&](const Pose2& pose) { return pose.yaw_rad > 0.0 ? fitness_to_left : fitness_to_right; };
    return CentreYaw({Pose2{1.0, 2.0, 0.0}, 0.8}, 0.02, Sides);
  };
  CHECK(Centred(0.6, 0.6) == Pose2{1.0, 2.0, 0.0});
  CheckPose(Centred(0.7, 0.6), {1.0, 2.0, 0.02 / 6.0}, 1e-9);  // a parabola through three points has its top there
  CheckPose(Centred(0.6, 0.7), {1.0, 2.0, -0.02 / 6.0}, 1e-9);
  CHECK(Centred(0.9, 0.6).yaw_rad == 0.02);
  CHECK(Centred(0.8, 0.795).yaw_rad == 0.0);
}

TEST_CASE("along an axis a higher hill is found within reach") {
  const auto TwoHills = [](const Pose2& pose) { return std::max(Hill(pose, kTop, 0.7), Hill(pose, kOther, 0.8)); };
  const auto Look = [&](const Eigen::Vector2d& axis, double reach_m, double least_gain) {
    return LookAlong(kTop, axis, reach_m, 0.05, least_gain, TwoHills);
  };
  CheckPose(Look(kAxis, 1.0, 0.02), kOther, 1e-9);
  CheckPose(Look(-kAxis, 1.0, 0.02), kOther, 1e-9);  // an axis has no direction
  CHECK(Look(kAxis, 0.5, 0.02) == kTop);             // out of reach
  CHECK(Look(kAxis, 1.0, 0.11) == kTop);             // not so much higher
  CHECK(Look({0.6, 0.8}, 1.0, 0.02) == kTop);        // not on the axis
}

}  // namespace crsm
