#include "common/math/trigonometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "catch.hpp"
#include "common/math/random.hpp"

namespace crsm {
namespace {

/// The larger error of the two, against the C library's in extended precision.
double SinCosError(double angle_rad) {
  const SinCos ours = ComputeSinCos(angle_rad);
  const auto exact = static_cast<long double>(angle_rad);
  return static_cast<double>(std::max(std::abs(ours.sin - std::sin(exact)), std::abs(ours.cos - std::cos(exact))));
}

}  // namespace

TEST_CASE("sine and cosine are exact to 4e-16 up to a million radians") {
  Random random(1);
  for (const double limit_rad : {0.1, kPi, 100.0, 1e6}) {
    double largest = 0.0;
    for (int i = 0; i < 20000; ++i) largest = std::max(largest, SinCosError(random.Uniform(-limit_rad, limit_rad)));
    CAPTURE(limit_rad);
    CHECK(largest <= 4e-16);
  }
}

TEST_CASE("sine and cosine are exact to 4e-16 where one quadrant ends and the next begins") {
  for (int eighth = -32; eighth <= 32; ++eighth) {
    const double angle_rad = eighth * kPi / 4.0;
    CAPTURE(eighth);
    CHECK(SinCosError(angle_rad) <= 4e-16);
    CHECK(SinCosError(std::nextafter(angle_rad, -100.0)) <= 4e-16);
    CHECK(SinCosError(std::nextafter(angle_rad, 100.0)) <= 4e-16);
  }
  CHECK(ComputeSinCos(0.0).sin == 0.0);
  CHECK(ComputeSinCos(0.0).cos == 1.0);
}

TEST_CASE("the exponential is exact to 1e-15 of its value") {
  Random random(2);
  double largest = 0.0;
  for (const double limit : {1e-6, 1.0, 30.0, 700.0}) {
    for (int i = 0; i < 5000; ++i) {
      const double x = random.Uniform(-limit, limit);
      const long double exact = std::exp(static_cast<long double>(x));
      largest = std::max(largest, static_cast<double>(std::abs(ComputeExp(x) - exact) / exact));
    }
  }
  CHECK(largest <= 1e-15);
  CHECK(ComputeExp(0.0) == 1.0);
}

TEST_CASE("a wrapped angle lies in [-pi, pi] and looks the same way; one that is not finite cannot be wrapped") {
  for (int tenth = -1000; tenth <= 1000; ++tenth) {
    const double angle_rad = 0.1 * tenth;
    const double wrapped_rad = WrapAngle(angle_rad);
    CAPTURE(angle_rad);
    CHECK(std::abs(wrapped_rad) <= kPi);
    // 2 pi in double precision is off by 2.4e-16, sixteen times in 100 rad.
    CHECK(std::cos(wrapped_rad) == Approx(std::cos(angle_rad)).margin(1e-14));
    CHECK(std::sin(wrapped_rad) == Approx(std::sin(angle_rad)).margin(1e-14));
  }
  CHECK(WrapAngle(3.0) == 3.0);
  CHECK(std::abs(WrapAngle(3.0 * kPi)) == Approx(kPi));
  CHECK_THROWS_AS(WrapAngle(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  CHECK_THROWS_AS(WrapAngle(std::numeric_limits<double>::infinity()), std::invalid_argument);
}

}  // namespace crsm
