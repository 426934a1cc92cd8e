#include "services/wire/ros_scan.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace crsm {
namespace {

/// Time from the first beam to the last [s]; 0 where the message says nothing of use.
double SweepTime(const RosScan& scan) {
  constexpr double kLongest_s = 1.0;
  const double sweep_s = static_cast<double>(scan.time_increment) * (static_cast<double>(scan.ranges.size()) - 1.0);
  return std::abs(sweep_s) <= kLongest_s ? sweep_s : 0.0;  // 0 for NaN
}

/// Whether something was hit there.
bool IsReturn(float range_m, const RosScan& scan) {
  const float least_m = scan.range_min > 0.0f ? scan.range_min : 0.0f;
  const bool has_limits = scan.range_max > least_m;  // false for NaN
  return std::isfinite(range_m) && (!has_limits || (range_m >= least_m && range_m < scan.range_max));
}

}  // namespace

std::int64_t ToUtime(const RosTime& time) { return (time.sec * kRosSecond_ns + time.nanosec + 500) / 1000; }

std::string DescribeContradiction(const RosScan& scan) {
  constexpr double kMostSteps = 1.5;  // apart: of a full turn some drivers tell the beam behind the last one
  const double span_rad = static_cast<double>(scan.angle_max) - static_cast<double>(scan.angle_min);
  const double step_rad = scan.angle_increment;
  const double sweep_rad = step_rad * (static_cast<double>(scan.ranges.size()) - 1.0);
  const bool are_opposite = span_rad * sweep_rad < 0.0;
  // Else the view leads through pi.
  const bool are_alike = std::abs(span_rad + sweep_rad) <= kMostSteps * std::abs(step_rad);
  if (!are_opposite || !are_alike) return "";
  return fmt::format(
      "headers contradict themselves: angle_increment is {:.4f} rad, but angle_max {:.4f} rad is {} than angle_min "
      "{:.4f} rad: angle_increment counts; if the map is a mirror image, --mirrored turns the scans round",
      scan.angle_increment, scan.angle_max, span_rad > 0.0 ? "more" : "less", scan.angle_min);
}

LaserScan FromRosScan(RosScan ros, const ScanParameters& parameters) {
  const double sweep_s = parameters.beam_times ? SweepTime(ros) : 0.0;
  const double last_s =
      parameters.beam_times ? std::max(0.0, sweep_s) : std::abs(parameters.sweep_s);  // after the stamp
  const std::int64_t last_ns = std::llround(last_s * kRosSecond_ns);
  LaserScan scan{ToUtime({ros.stamp.sec, ros.stamp.nanosec + last_ns}), ros.angle_min, ros.angle_increment, {}};
  for (std::size_t beam = 0; sweep_s != 0.0 && beam < ros.ranges.size(); ++beam) {
    scan.times_s.push_back(
        static_cast<float>(static_cast<double>(beam) * static_cast<double>(ros.time_increment) - last_s));
  }
  for (float& range_m : ros.ranges) {
    if (!IsReturn(range_m, ros)) range_m = 0.0f;
  }
  scan.ranges_m = std::move(ros.ranges);
  return scan;
}

}  // namespace crsm
