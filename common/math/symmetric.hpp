#pragma once

#include <Eigen/Core>
#include <cmath>
#include <utility>

namespace crsm {

/// Unit eigenvector of the smaller eigenvalue of a symmetric matrix, and that eigenvalue.
inline std::pair<double, Eigen::Vector2d> FindWeakest(const Eigen::Matrix2d& a) {
  const double mean = 0.5 * (a(0, 0) + a(1, 1));
  const double half = 0.5 * (a(0, 0) - a(1, 1));
  const double radius = std::sqrt(half * half + a(0, 1) * a(0, 1));
  // Of the two ways to write the vector the one without cancellation.
  const Eigen::Vector2d axis =
      half > 0.0 ? Eigen::Vector2d(-a(0, 1), radius + half) : Eigen::Vector2d(radius - half, -a(0, 1));
  const double norm = axis.norm();
  return {mean - radius, norm > 0.0 ? Eigen::Vector2d(axis / norm) : Eigen::Vector2d::UnitX()};
}

}  // namespace crsm
