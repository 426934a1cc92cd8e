#pragma once

#include <Eigen/Core>

namespace crsm {

/// A fitness with its derivatives by the pose: x, y [m] and yaw [rad].
struct FitnessDerivatives {
  double value = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
};

}  // namespace crsm
