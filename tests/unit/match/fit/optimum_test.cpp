#include "common/match/fit/optimum.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "catch.hpp"
#include "check_pose.hpp"
#include "hill.hpp"

namespace crsm {
namespace {

/// Another hill, 0.6 m along an axis from the first.
const Eigen::Vector2d kAxis(0.8, -0.6);
const Pose2 kOther{kTop.x_m + 0.6 * kAxis.x(), kTop.y_m + 0.6 * kAxis.y(), kTop.yaw_rad};

/// A bell with its top at kTop: from a width on it is no hill.
FitnessDerivatives DifferentiateBell(const Pose2& pose) {
  const Eigen::Array3d width(0.3, 0.3, 0.15);
  const Eigen::Array3d from_top(pose.x_m - kTop.x_m, pose.y_m - kTop.y_m, pose.yaw_rad - kTop.yaw_rad);
  const double value = std::exp(-0.5 * (from_top / width).square().sum());
  const Eigen::Vector3d slope = (-from_top / width.square()).matrix();
  const Eigen::Matrix3d round = width.square().inverse().matrix().asDiagonal();
  return {value, value * slope, value * (slope * slope.transpose() - round)};
}

}  // namespace

TEST_CASE("a climb by halving steps ends within the last of them of the optimum") {
  const ScoredPose top = ClimbToOptimum({0.3, -0.2, 0.1}, 0.05, 0.01, 6, OneHill);
  CheckPose(top.pose, kTop, 0.001);
  CHECK(top.fitness == OneHill(top.pose));
}

TEST_CASE(
    "the yaw goes to the top of a parabola, to the middle of an optimum with one flank, and not beyond the width") {
  const Pose2 top{1.0, 2.0, 0.0};
  const auto Centred = [&](auto&& fitness) {
    return CentreYaw({top, fitness(0.0)}, 0.02, [&](const Pose2& pose) {
      CHECK(std::abs(pose.yaw_rad) <= 0.02);
      return fitness(pose.yaw_rad);
    });
  };
  const auto Parabola = [](double middle_rad) {
    return [=](double yaw_rad) { return 0.8 - 5000.0 * (yaw_rad - middle_rad) * (yaw_rad - middle_rad); };
  };
  CHECK(Centred(Parabola(0.0)) == top);
  CheckPose(Centred(Parabola(0.002)), {1.0, 2.0, 0.002}, 1e-9);
  CheckPose(Centred(Parabola(-0.002)), {1.0, 2.0, -0.002}, 1e-9);
  // Where one side is as high as the top, each width has the middle half-way there.
  const auto Flank = [](double yaw_rad) { return yaw_rad > 0.0 ? 0.8 : 0.8 + 100.0 * yaw_rad; };
  CheckPose(Centred(Flank), {1.0, 2.0, 0.5 * (0.02 + 0.01 + 0.005 + 0.0025) / 4.0}, 1e-9);  // all are as steep
  const auto Higher = [](double yaw_rad) { return yaw_rad > 0.0 ? 0.9 : (yaw_rad < 0.0 ? 0.5 : 0.8); };
  CheckPose(Centred(Higher), {1.0, 2.0, 0.02 * 4.0 / 15.0}, 1e-9);  // each goes its whole width
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

TEST_CASE("Newton's method ends on the top of a hill within some passes, also from where it is no hill") {
  for (const Pose2& from : {Pose2{0.3, -0.2, 0.1}, kTop, Pose2{kTop.x_m + 0.4, kTop.y_m, kTop.yaw_rad - 0.1}}) {
    int num = 0;
    const ScoredPose top = ClimbByNewton(from, 0.05, [&](const Pose2& pose) {
      ++num;
      return DifferentiateBell(pose);
    });
    CheckPose(top.pose, kTop, 1e-4);
    CHECK(top.fitness == DifferentiateBell(top.pose).value);
    CHECK(num <= 20);
  }
}

TEST_CASE("no step of Newton's method is longer than a cell, or than a hundredth of a radian, nor leads down") {
  double highest = -1.0;
  std::optional<Pose2> best;
  ClimbByNewton({kTop.x_m + 0.5, kTop.y_m - 0.5, kTop.yaw_rad + 0.2}, 0.05, [&](const Pose2& pose) {
    if (best) {
      CHECK(std::abs(pose.x_m - best->x_m) <= 0.05 + 1e-9);
      CHECK(std::abs(pose.y_m - best->y_m) <= 0.05 + 1e-9);
      CHECK(std::abs(pose.yaw_rad - best->yaw_rad) <= 0.01 + 1e-9);
    }
    const FitnessDerivatives here = DifferentiateBell(pose);
    if (here.value > highest) {
      highest = here.value;
      best = pose;
    }
    return here;
  });
}

TEST_CASE("on a plain a climb stays where it is, and ends") {
  int num_asked = 0;
  const auto Plain = [&](const Pose2&) {
    if (++num_asked > 1000) throw std::runtime_error("the climb has no end");
    return 0.5;
  };
  CHECK(ClimbToOptimum(kTop, 0.05, 0.01, 6, Plain).pose == kTop);
  CHECK(num_asked == 1 + 6 * 6);  // two directions on each of three axes, at each of six steps
  int num_passes = 0;
  const ScoredPose top = ClimbByNewton(kTop, 0.05, [&](const Pose2&) {
    ++num_passes;
    return FitnessDerivatives{0.5, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  });
  CHECK(top.pose == kTop);
  CHECK(num_passes <= 2);
}

TEST_CASE("an optimum that is flat in its midst has a middle if it falls by enough outside") {
  const auto Centred = [](double fall) {  // at the largest width, all of it to the right
    return CentreYaw({Pose2{}, 0.8}, 0.02, [&](const Pose2& pose) { return pose.yaw_rad > -0.015 ? 0.8 : 0.8 - fall; });
  };
  CHECK(Centred(0.019).yaw_rad == 0.0);           // noise
  CHECK(Centred(0.021).yaw_rad == Approx(0.01));  // a parabola with equal values at 0 and 0.02
  CHECK(Centred(0.3).yaw_rad == Approx(0.01));    // as steep as it may be
  const auto Plateau = [](const Pose2& pose) {    // from -0.01 to 0.014
    return 0.8 - 50.0 * std::max(0.0, std::abs(pose.yaw_rad - 0.002) - 0.012);
  };
  CHECK(CentreYaw({Pose2{}, 0.8}, 0.02, Plateau).yaw_rad == Approx(0.0025));  // the largest width alone
}

TEST_CASE("a look along an axis goes to both its ends and beyond neither, in steps along it") {
  const Eigen::Vector2d axis(0.6, 0.8);
  for (const double sign : {1.0, -1.0}) {
    const auto Slope = [&](const Pose2& pose) { return sign * (0.6 * pose.x_m + 0.8 * pose.y_m); };
    const Pose2 end = LookAlong({1.0, 2.0, 0.3}, axis, 0.5, 0.125, 0.02, Slope);
    CheckPose(end, {1.0 + sign * 0.3, 2.0 + sign * 0.4, 0.3}, 1e-9);
  }
}

}  // namespace crsm
