#pragma once

#include <cstdint>

#include "common/metrics/trajectory.hpp"

namespace crsm {

struct TrajectoryError {
  std::int64_t num_poses = 0;
  double mean_m = 0.0;
  double median_m = 0.0;
  double max_m = 0.0;
  double rmse_m = 0.0;
  double max_rad = 0.0;
};

/// The trajectory turned and moved as a whole to where its poses are nearest to those of the truth, by the least mean
/// square of their distances (Umeyama 1991, without a scale). Throws std::runtime_error if they have no moment in
/// common.
Trajectory Align(const Trajectory& trajectory, const Trajectory& truth);

/// Absolute error of the poses whose utime is in the truth; nothing is aligned.
/// Throws std::runtime_error if there is none.
TrajectoryError EvaluateTrajectory(const Trajectory& trajectory, const Trajectory& truth);

}  // namespace crsm
