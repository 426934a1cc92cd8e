#include "common/metrics/relations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <unordered_map>

namespace crsm {

namespace {

using PoseByUtime = std::unordered_map<std::int64_t, Pose2>;

const Pose2* FindPose(const PoseByUtime& poses, std::int64_t utime) {
  for (const std::int64_t offset_us : {0, 1, -1, 2, -2}) {
    const auto found = poses.find(utime + offset_us);
    if (found != poses.end()) return &found->second;
  }
  return nullptr;
}

/// At least one error.
ErrorStatistics Summarize(std::vector<double> errors) {
  std::sort(errors.begin(), errors.end());
  const auto count = static_cast<double>(errors.size());
  ErrorStatistics statistics;
  for (const double error : errors) statistics.mean += error / count;
  double variance = 0.0;
  for (const double error : errors) variance += (error - statistics.mean) * (error - statistics.mean) / count;
  statistics.standard_deviation = std::sqrt(variance);
  statistics.median = 0.5 * (errors[(errors.size() - 1) / 2] + errors[errors.size() / 2]);
  statistics.max = errors.back();
  return statistics;
}

}  // namespace

std::vector<Relation> ReadRelations(const std::string& path) {
  std::vector<Relation> relations;
  for (const auto& [line, numbers] : ReadNumberRows(path, "t1 t2 x y z roll pitch yaw")) {
    const auto& [first_s, second_s, x_m, y_m, z_m, roll_rad, pitch_rad, yaw_rad] = numbers;
    if (z_m != 0.0 || roll_rad != 0.0 || pitch_rad != 0.0) {
      throw std::runtime_error(
          fmt::format("{}:{}: z, roll and pitch must be 0: only motion in the plane is compared", path, line));
    }
    relations.push_back({ToUtime(first_s), ToUtime(second_s), {x_m, y_m, WrapAngle(yaw_rad)}});
  }
  return relations;
}

RelationErrors EvaluateRelations(const std::vector<Relation>& relations, const Trajectory& trajectory,
                                 const Pose2& T_robot_laser) {
  const Pose2 T_laser_robot = Inverse(T_robot_laser);
  PoseByUtime T_map_robot;
  for (const auto& [utime, T_map_laser] : trajectory) T_map_robot.emplace(utime, T_map_laser * T_laser_robot);

  std::vector<double> translations_m;
  std::vector<double> rotations_rad;
  for (const auto& [first_utime, second_utime, T_first_second] : relations) {
    const Pose2* T_map_first = FindPose(T_map_robot, first_utime);
    const Pose2* T_map_second = FindPose(T_map_robot, second_utime);
    if (!T_map_first || !T_map_second) continue;
    const Pose2 error = Inverse(T_first_second) * (Inverse(*T_map_first) * *T_map_second);
    translations_m.push_back(std::hypot(error.x_m, error.y_m));
    rotations_rad.push_back(std::abs(error.yaw_rad));
  }
  if (translations_m.empty()) {
    throw std::runtime_error(
        fmt::format("none of the {} relations has both its times among the {} poses of the trajectory: are both files "
                    "of the same log?",
                    relations.size(), trajectory.size()));
  }
  const auto num_used = static_cast<std::int64_t>(translations_m.size());
  return {num_used, static_cast<std::int64_t>(relations.size()) - num_used, Summarize(std::move(translations_m)),
          Summarize(std::move(rotations_rad))};
}

}  // namespace crsm
