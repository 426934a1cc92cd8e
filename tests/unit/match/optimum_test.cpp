#include "common/match/optimum.hpp"

#include <algorithm>
#include <stdexcept>

#include "catch.hpp"
#include "check_pose.hpp"
#include "hill.hpp"

namespace crsm {
namespace {

/// Another hill, 0.6 m along an axis from the first.
const Eigen::Vector2d kAxis(0.8, -0.6);
const Pose2 kOther{kTop.x_m + 0.6 * kAxis.x(), kTop.y_m + 0.6 * kAxis.y(), kTop.yaw_rad};

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

TEST_CASE("an optimum is found to half a cell by one fitness, and on from there by a finer one") {
  const Pose2 fine_top{kTop.x_m + 0.01, kTop.y_m - 0.01, kTop.yaw_rad + 0.002};  // a quarter of a cell away, together
  int num_fine = 0;
  const auto Fine = [&](const Pose2& pose) {
    ++num_fine;
    return Hill(pose, fine_top, 0.8);
  };
  CheckPose(FindOptimum({0.3, -0.2, 0.1}, 0.05, 0.0, OneHill, Fine), fine_top, 0.002);
  int num_all = 0;
  const auto Counted = [&](const Pose2& pose) {
    ++num_all;
    return Hill(pose, fine_top, 0.8);
  };
  FindOptimum({0.3, -0.2, 0.1}, 0.05, 0.0, Counted, Counted);
  CHECK(num_fine < num_all);  // the long way there costs little
}

TEST_CASE("on a plain a climb stays where it is, and ends") {
  int num_asked = 0;
  const auto Plain = [&](const Pose2&) {
    if (++num_asked > 1000) throw std::runtime_error("the climb has no end");
    return 0.5;
  };
  CHECK(ClimbToOptimum(kTop, 0.05, 0.01, 6, Plain).pose == kTop);
  CHECK(num_asked == 1 + 6 * 6);  // two directions on each of three axes, at each of six steps
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
