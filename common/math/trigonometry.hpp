#pragma once

namespace crsm {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kFullTurn_rad = 2.0 * kPi + 1e-3;  ///< which an angle in single precision may miss by a little

/// Whether an angle [rad] is at most a full turn. False for NaN.
constexpr bool IsWithinFullTurn(double angle_rad) { return angle_rad <= kFullTurn_rad && angle_rad >= -kFullTurn_rad; }

struct SinCos {
  double sin;
  double cos;
};

/// Sine and cosine of `angle_rad` to within 4e-16 for |angle_rad| <= 1e6.
///
/// Made of additions and multiplications only, which IEEE 754 rounds alike everywhere. The C library's own may
/// differ in the last bit between CPUs, and one bit is enough to send a hill climb elsewhere: nothing that
/// decides about a pose or a cell calls it.
SinCos ComputeSinCos(double angle_rad);

/// e^x to within 1e-15 relative for |x| <= 700, by the same means and for the same reason.
double ComputeExp(double x);

/// The direction of (x, y), which is not the origin, on the turn of `guess_rad`, which is at most pi / 2 off: atan2 by
/// the same means and for the same reason.
double HeadingOf(double x, double y, double guess_rad);

/// The angle brought to [-pi, pi]. Throws std::invalid_argument if it is not finite.
double WrapAngle(double angle_rad);

}  // namespace crsm
