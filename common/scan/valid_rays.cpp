#include "common/scan/valid_rays.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/math/trigonometry.hpp"

namespace crsm {

double LargestUsableRange(const ScanParameters& parameters, const ValidRayConstants& constants) {
  return constants.usable_share * parameters.range_max_m;
}

namespace {

/// When a beam was measured, after the scan's utime [s], where the scan does not say.
float TimeOf(std::size_t beam, std::size_t num_beams, double sweep_s) {
  const double share = static_cast<double>(beam) / static_cast<double>(std::max<std::size_t>(num_beams, 2) - 1);
  return static_cast<float>(sweep_s < 0.0 ? sweep_s * share : -sweep_s * (1.0 - share));
}

}  // namespace

ValidRays FindValidRays(const LaserScan& scan, const ScanParameters& parameters, const ValidRayConstants& constants) {
  const double max_m = LargestUsableRange(parameters, constants);
  const auto angle_scale = static_cast<float>(parameters.angle_scale);

  const bool says_times = parameters.beam_times && !scan.times_s.empty();
  const bool has_times = says_times || parameters.sweep_s != 0.0;

  ValidRays rays;
  for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
    const float range_m = scan.ranges_m[beam];
    if (!std::isfinite(range_m) || range_m <= 0.0f || range_m < parameters.range_min_m || range_m > max_m) continue;
    rays.angle_rad.push_back(angle_scale * (scan.angle_min_rad + static_cast<float>(beam) * scan.angle_step_rad));
    rays.range_m.push_back(range_m);
    if (!has_times) continue;
    rays.time_s.push_back(says_times ? scan.times_s[beam] : TimeOf(beam, scan.ranges_m.size(), parameters.sweep_s));
  }
  if (scan.angle_step_rad < 0.0f) {
    std::reverse(rays.angle_rad.begin(), rays.angle_rad.end());
    std::reverse(rays.range_m.begin(), rays.range_m.end());
    std::reverse(rays.time_s.begin(), rays.time_s.end());
  }
  return rays;
}

std::vector<double> ComputeDisplacements(const ValidRays& rays) {
  std::vector<double> displacements;
  for (std::size_t i = 0; i + 1 < rays.size(); ++i) {
    const double a = rays.range_m[i];
    const double b = rays.range_m[i + 1];
    const double cos = ComputeSinCos(static_cast<double>(rays.angle_rad[i + 1]) - rays.angle_rad[i]).cos;
    displacements.push_back(std::sqrt(std::max(0.0, a * a + b * b - 2.0 * a * b * cos)));
  }
  return displacements;
}

double ComputeMeanSparseness(const ValidRays& rays) {
  if (rays.size() < 2) return 0.0;
  const std::vector<double> displacements = ComputeDisplacements(rays);
  return std::accumulate(displacements.begin(), displacements.end(), 0.0) / static_cast<double>(displacements.size());
}

}  // namespace crsm
