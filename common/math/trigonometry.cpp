#include "common/math/trigonometry.hpp"

#include <cmath>
#include <stdexcept>

namespace crsm {

namespace {

/// std::nearbyint for |x| < 2^51, which is a function call on the x86-64 that every machine has: added to 1.5 * 2^52 a
/// number loses what is behind its point.
double RoundToWhole(double x) {
  constexpr double kNoFractions = 6755399441055744.0;
  return (x + kNoFractions) - kNoFractions;
}

}  // namespace

SinCos ComputeSinCos(double angle_rad) {
  // Cody and Waite: pi/2 in two parts, of which the first has zeros enough that its multiples are exact.
  constexpr double kHalfPiHigh = 1.57079632673412561417e+00;
  constexpr double kHalfPiLow = 6.07710050650619224932e-11;
  const double quadrant = RoundToWhole(angle_rad * (2.0 / kPi));
  const double r = (angle_rad - quadrant * kHalfPiHigh) - quadrant * kHalfPiLow;

  // Taylor series on [-pi/4, pi/4]; the first term left out is below 1e-17.
  const double r2 = r * r;
  double sin = 1.0 / 355687428096000.0;
  for (const double divisor : {-1307674368000.0, 6227020800.0, -39916800.0, 362880.0, -5040.0, 120.0, -6.0}) {
    sin = sin * r2 + 1.0 / divisor;
  }
  sin = r + r * r2 * sin;
  double cos = 1.0 / 20922789888000.0;
  for (const double divisor : {-87178291200.0, 479001600.0, -3628800.0, 40320.0, -720.0, 24.0, -2.0}) {
    cos = cos * r2 + 1.0 / divisor;
  }
  cos = 1.0 + r2 * cos;

  switch (static_cast<long long>(quadrant) & 3) {
    case 0:
      return {sin, cos};
    case 1:
      return {cos, -sin};
    case 2:
      return {-sin, -cos};
    default:
      return {-cos, sin};
  }
}

double ComputeExp(double x) {
  constexpr double kLn2High = 6.93147180369123816490e-01;
  constexpr double kLn2Low = 1.90821492927058770002e-10;
  const double exponent = RoundToWhole(x / (kLn2High + kLn2Low));
  const double r = (x - exponent * kLn2High) - exponent * kLn2Low;
  double term = 1.0;
  double sum = 1.0;
  for (int n = 1; n <= 14; ++n) {
    term *= r / n;
    sum += term;
  }
  return std::ldexp(sum, static_cast<int>(exponent));
}

double HeadingOf(double x, double y, double guess_rad) {
  // Each step subtracts the sine of the error, which leaves its cube / 6: six take pi / 2 to rounding.
  constexpr int kSteps = 6;
  const double length = std::sqrt(x * x + y * y);
  double heading_rad = guess_rad;
  for (int i = 0; i < kSteps; ++i) {
    const auto [sin, cos] = ComputeSinCos(heading_rad);
    heading_rad += (cos * y - sin * x) / length;
  }
  return heading_rad;
}

double WrapAngle(double angle_rad) {
  if (!std::isfinite(angle_rad)) throw std::invalid_argument("WrapAngle: the angle is not finite");
  if (std::abs(angle_rad) <= kPi) return angle_rad;
  return std::remainder(angle_rad, 2.0 * kPi);
}

}  // namespace crsm
