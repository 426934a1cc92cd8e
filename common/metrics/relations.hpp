#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose2.hpp"
#include "common/metrics/trajectory.hpp"

namespace crsm {

/// What is known to be true about two moments of a log: the robot's pose at the second seen from the first.
struct Relation {
  std::int64_t first_utime = 0;
  std::int64_t second_utime = 0;
  Pose2 T_first_second;
};

/// Reads a relations file, `t1 t2 x y z roll pitch yaw` a line [s, m, rad].
/// Throws std::runtime_error that names the file and the line; z, roll and pitch must be 0.
std::vector<Relation> ReadRelations(const std::string& path);

/// Of errors >= 0. The standard deviation is of all the errors (divided by their number, not by one less).
struct ErrorStatistics {
  double mean = 0.0;
  double standard_deviation = 0.0;
  double median = 0.0;
  double max = 0.0;
};

struct RelationErrors {
  std::int64_t num_used = 0;
  std::int64_t num_missing = 0;  ///< relations of which the trajectory lacks a moment
  ErrorStatistics translation_m;
  ErrorStatistics rotation_rad;
};

/// Compares a trajectory with relations of the robot's frame, in which the laser stands at `T_robot_laser`.
///
/// Error of a relation: reference^-1 * estimate; its length, and its absolute angle. Moments are matched to within
/// 2 us, because both files print rounded seconds; the first pose of a repeated utime counts.
/// Throws std::runtime_error if no relation can be used.
/// Source: Kuemmerle et al., "On measuring the accuracy of SLAM algorithms", Autonomous Robots 27, 2009.
RelationErrors EvaluateRelations(const std::vector<Relation>& relations, const Trajectory& trajectory,
                                 const Pose2& T_robot_laser);

}  // namespace crsm
