#pragma once

#include <cmath>
#include <cstddef>
#include <utility>

#include "common/math/pose2.hpp"
#include "common/math/trigonometry.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// Makes a scan of a turn whose beams have angles of their own, uneven. Each goes to the nearest of 1440 beams, 0.25
/// deg apart from the first one on, in the order in which they were measured: its angle is off by 0.125 deg at most. Of
/// two on one beam the nearer counts; beams that nothing falls on are 0 = no return.
class PolarGrid {
 public:
  enum class Sense { kClockwise, kCounterClockwise };  ///< of the angles, and of the grid

  /// first_rad: of the first beam, from x. has_times: whether the beams have times.
  explicit PolarGrid(double first_rad, Sense sense = Sense::kClockwise, bool has_times = false)
      : first_rad_(first_rad) {
    const double sign = sense == Sense::kClockwise ? -1.0 : 1.0;
    scan_.angle_min_rad = static_cast<float>(WrapAngle(sign * first_rad));
    scan_.angle_step_rad = static_cast<float>(sign * kStep_rad);
    scan_.ranges_m.assign(kBeams, 0.0f);
    if (has_times) scan_.times_s.assign(kBeams, 0.0f);
  }

  /// range_m: not above 0 where nothing was seen. time_s: after the scan's utime.
  void Add(double angle_rad, float range_m, float time_s = 0.0f) {
    if (!(range_m > 0.0f)) return;
    const long steps = std::lround((angle_rad - first_rad_) / kStep_rad) % kBeams;
    const auto beam = static_cast<std::size_t>(steps < 0 ? steps + kBeams : steps);
    float& nearest_m = scan_.ranges_m[beam];
    if (nearest_m != 0.0f && range_m >= nearest_m) return;
    nearest_m = range_m;
    if (!scan_.times_s.empty()) scan_.times_s[beam] = time_s;
  }

  /// Its utime is not set.
  LaserScan TakeScan() { return std::move(scan_); }

 private:
  static constexpr int kBeams = 1440;
  static constexpr double kStep_rad = 2.0 * kPi / kBeams;

  double first_rad_;
  LaserScan scan_;
};

}  // namespace crsm
