#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <stdexcept>

#include "common/metrics/trajectory.hpp"

namespace crsm {

void AppendPose(const StampedPose& pose, std::string& text) {
  const auto& [utime, T_map_laser] = pose;
  const auto& [x_m, y_m, yaw_rad] = T_map_laser;
  if (!std::isfinite(x_m) || !std::isfinite(y_m) || !std::isfinite(yaw_rad)) {
    throw std::invalid_argument(fmt::format("a trajectory: the pose of utime {} is not finite", utime));
  }
  const auto [sin, cos] = ComputeSinCos(0.5 * WrapAngle(yaw_rad));
  const auto magnitude = utime < 0 ? -static_cast<std::uint64_t>(utime) : static_cast<std::uint64_t>(utime);
  // Adding 0.0 makes 0 of -0: the two are equal and print alike.
  fmt::format_to(std::back_inserter(text), "{}{}.{:06} {:.9f} {:.9f} 0 0 0 {:.9f} {:.9f}\n", utime < 0 ? "-" : "",
                 magnitude / 1000000, magnitude % 1000000, x_m + 0.0, y_m + 0.0, sin + 0.0, cos);
}

std::string FormatTrajectory(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& pose : trajectory) AppendPose(pose, text);
  return text;
}

}  // namespace crsm
