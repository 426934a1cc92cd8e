#include "services/wire/ros_scan.hpp"

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
