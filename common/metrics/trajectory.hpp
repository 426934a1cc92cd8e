#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose2.hpp"

namespace crsm {

struct StampedPose {
  std::int64_t utime = 0;  ///< the scan's [us since the epoch of the log]
  Pose2 T_map_laser;

  friend bool operator==(const StampedPose&, const StampedPose&) = default;
};

/// One pose a scan, in the order of the scans: utimes need not rise.
using Trajectory = std::vector<StampedPose>;

/// The trajectory as TUM text, `t x y z qx qy qz qw` a line: t [s] to the microsecond from the integer, lengths [m]
/// and the unit quaternion to 9 decimals, z = 0. Equal trajectories give equal bytes on every machine.
/// Throws std::invalid_argument if a pose is not finite.
std::string FormatTrajectory(const Trajectory& trajectory);

/// Appends one line of it.
void AppendPose(const StampedPose& pose, std::string& text);

/// Reads a TUM file; of each pose it keeps x, y and the yaw. Utimes come back exact to +-4e15 us (the year 2096).
/// Throws std::runtime_error that names the file and the line.
Trajectory ReadTrajectory(const std::string& path);

/// A line of eight numbers, which is what trajectories and relations are both made of.
struct NumberRow {
  std::int64_t line = 0;  ///< from 1
  std::array<double, 8> numbers{};
};

/// The rows of a text file, plain or gzip. Empty lines and lines that begin with '#' are passed over.
///
/// `columns` names the eight numbers in errors. Throws std::runtime_error that names the file and the line if a row
/// has not exactly eight numbers within +-4.5e9, beyond which microseconds would not be exact.
std::vector<NumberRow> ReadNumberRows(const std::string& path, const char* columns);

/// Microseconds from seconds. |t_s| <= 4.5e9.
std::int64_t ToUtime(double t_s);

}  // namespace crsm
