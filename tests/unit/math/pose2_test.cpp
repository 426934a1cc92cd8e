#include "common/math/pose2.hpp"

#include <cmath>

#include "catch.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

void CheckSame(const Pose2& a, const Pose2& b) {
  CHECK(a.x_m == Approx(b.x_m).margin(1e-12));
  CHECK(a.y_m == Approx(b.y_m).margin(1e-12));
  CHECK(WrapAngle(a.yaw_rad - b.yaw_rad) == Approx(0.0).margin(1e-12));
}

Pose2 DrawPose(Random& random) {
  return {random.Uniform(-10.0, 10.0), random.Uniform(-10.0, 10.0), random.Uniform(-kPi, kPi)};
}

}  // namespace

TEST_CASE("one metre ahead after a quarter turn is one metre to the left") {
  CheckSame(Pose2{2.0, 3.0, kPi / 2.0} * Pose2{1.0, 0.0, 0.0}, {2.0, 4.0, kPi / 2.0});
}

TEST_CASE("poses are chained like matrices, and a pose and its inverse cancel") {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const Pose2 a = DrawPose(random);
    const Pose2 b = DrawPose(random);
    const Pose2 c = DrawPose(random);
    CheckSame((a * b) * c, a * (b * c));
    CheckSame(a * Inverse(a), {});
    CheckSame(Inverse(a) * a, {});
    const Pose2 product = a * b;
    CHECK(product.x_m == Approx(a.x_m + std::cos(a.yaw_rad) * b.x_m - std::sin(a.yaw_rad) * b.y_m));
    CHECK(product.y_m == Approx(a.y_m + std::sin(a.yaw_rad) * b.x_m + std::cos(a.yaw_rad) * b.y_m));
  }
}

TEST_CASE("the heading of a product stays in [-pi, pi]") {
  const Pose2 product = Pose2{0.0, 0.0, 3.0} * Pose2{0.0, 0.0, 3.0};
  CHECK(product.yaw_rad == Approx(6.0 - 2.0 * kPi));
}

}  // namespace crsm
