#include "common/metrics/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "common/math/alignment.hpp"

namespace crsm {
namespace {

struct PosePair {
  Pose2 pose;
  Pose2 true_pose;
};

/// Of each moment of the trajectory that the truth has too.
std::vector<PosePair> FindPairs(const Trajectory& trajectory, const Trajectory& truth) {
  std::map<std::int64_t, Pose2> true_poses;
  for (const StampedPose& stamped : truth) true_poses.emplace(stamped.utime, stamped.T_map_laser);
  std::vector<PosePair> pairs;
  for (const StampedPose& stamped : trajectory) {
    const auto found = true_poses.find(stamped.utime);
    if (found != true_poses.end()) pairs.push_back({stamped.T_map_laser, found->second});
  }
  if (pairs.empty()) throw std::runtime_error("the trajectory and the truth have no moment in common");
  return pairs;
}

}  // namespace

Trajectory Align(const Trajectory& trajectory, const Trajectory& truth) {
  std::vector<Pose2> poses, true_poses;
  for (const auto& [pose, true_pose] : FindPairs(trajectory, truth)) {
    poses.push_back(pose);
    true_poses.push_back(true_pose);
  }
  const auto [mean, true_mean, sin, cos] = FindAlignment(poses, true_poses);
  const Pose2 T_truth_map =
      Pose2{true_mean.x_m, true_mean.y_m, std::atan2(sin, cos)} * Inverse(Pose2{mean.x_m, mean.y_m, 0.0});
  Trajectory aligned = trajectory;
  for (StampedPose& stamped : aligned) stamped.T_map_laser = T_truth_map * stamped.T_map_laser;
  return aligned;
}

TrajectoryError EvaluateTrajectory(const Trajectory& trajectory, const Trajectory& truth) {
  TrajectoryError error;
  std::vector<double> distances_m;
  double squares_m2 = 0.0;
  for (const auto& [pose, true_pose] : FindPairs(trajectory, truth)) {
    const Pose2 wrong = Inverse(true_pose) * pose;
    distances_m.push_back(std::sqrt(wrong.x_m * wrong.x_m + wrong.y_m * wrong.y_m));
    squares_m2 += distances_m.back() * distances_m.back();
    error.mean_m += distances_m.back();
    error.max_rad = std::max(error.max_rad, std::abs(wrong.yaw_rad));
  }
  std::sort(distances_m.begin(), distances_m.end());
  const std::size_t n = distances_m.size();
  error.num_poses = static_cast<std::int64_t>(n);
  error.mean_m /= static_cast<double>(n);
  error.rmse_m = std::sqrt(squares_m2 / static_cast<double>(n));
  error.median_m = 0.5 * (distances_m[(n - 1) / 2] + distances_m[n / 2]);
  error.max_m = distances_m.back();
  return error;
}

}  // namespace crsm
