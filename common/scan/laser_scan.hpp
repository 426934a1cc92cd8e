#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/trigonometry.hpp"

namespace crsm {

inline constexpr std::size_t kMinBeams = 2;
inline constexpr std::size_t kMaxBeams = 4096;
inline constexpr float kLongestSweep_s = 2.0f;  ///< beams are measured no further from the utime of their scan

/// Whether the beams of a scan are in different directions, and no more than a full turn apart. All lasers are; what
/// is not was given in degrees, or is damaged.
inline bool AreBeamAngles(float angle_min_rad, float angle_step_rad, std::size_t num_beams) {
  const double sweep_rad = static_cast<double>(angle_step_rad) * (static_cast<double>(num_beams) - 1.0);
  return num_beams >= kMinBeams && angle_step_rad != 0.0f && IsWithinFullTurn(angle_min_rad) &&
         IsWithinFullTurn(sweep_rad);
}

/// One sweep of a planar laser, as it is measured and as it travels: single precision, so that a scan read from a
/// file and one that came over the wire are the same scan.
struct LaserScan {
  std::int64_t utime = 0;       ///< identity of the scan [us since the epoch of the log]
  float angle_min_rad = 0.0f;   ///< of beam 0, laser frame, counter-clockwise from x
  float angle_step_rad = 0.0f;  ///< from a beam to the next; negative for lasers that turn clockwise
  std::vector<float> ranges_m;  ///< along each beam; <= 0, NaN or beyond the laser's reach: no return
  /// When each beam was measured, after utime [s], negative before it; empty where that is not known.
  std::vector<float> times_s = {};

  friend bool operator==(const LaserScan&, const LaserScan&) = default;
};

/// The mirror image of a scan: right where the laser hangs upside down, or counts its angles clockwise.
inline LaserScan Mirror(LaserScan scan) {
  scan.angle_min_rad = -scan.angle_min_rad;
  scan.angle_step_rad = -scan.angle_step_rad;
  return scan;
}

}  // namespace crsm
