#include "common/scan/deskew.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/math/trigonometry.hpp"
#include "common/parameters.hpp"

namespace crsm {
namespace {

// Limits of what goes over the wire.
constexpr double kMostAngle_rad = 4.0 * kPi;
constexpr double kShortest_m = 1e-3;

/// Rays in an order of their own: where each one went.
struct Deskewed {
  ValidRays rays;
  std::vector<int> index_of;  ///< of each ray in the sweep
};

Deskewed DeskewAndSort(const ValidRays& sweep, const Twist& twist) {
  struct Ray {
    double angle_rad;
    double range_m;
  };
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    const double time_s = sweep.time_s[i];
    const double angle_rad = sweep.angle_rad[i] + twist.yaw_rad_s * time_s;
    const auto [sin, cos] = ComputeSinCos(angle_rad);
    const double x_m = sweep.range_m[i] * cos + twist.x_m_s * time_s;
    const double y_m = sweep.range_m[i] * sin + twist.y_m_s * time_s;
    const double range_m = std::sqrt(x_m * x_m + y_m * y_m);
    // Whatever came over the wire goes on over it.
    const double heading_rad = range_m > 0.0 ? HeadingOf(x_m, y_m, angle_rad) : angle_rad;
    rays.push_back(
        {std::clamp(heading_rad, -kMostAngle_rad, kMostAngle_rad), std::clamp(range_m, kShortest_m, kLongestRange_m)});
  }
  std::vector<int> order(sweep.size());
  std::iota(order.begin(), order.end(), 0);
  const auto RayAt = [&](int i) -> const Ray& { return rays[static_cast<std::size_t>(i)]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return RayAt(a).angle_rad < RayAt(b).angle_rad; });
  Deskewed deskewed;
  deskewed.index_of.resize(sweep.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    deskewed.rays.angle_rad.push_back(static_cast<float>(RayAt(order[i]).angle_rad));
    deskewed.rays.range_m.push_back(static_cast<float>(RayAt(order[i]).range_m));
    deskewed.index_of[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
  }
  return deskewed;
}

}  // namespace

CriticalRays Deskew(const CriticalRays& scan, const Twist& twist) {
  if (scan.rays.time_s.empty()) return scan;
  Deskewed deskewed = DeskewAndSort(scan.rays, twist);
  CriticalRays result{scan.utime, std::move(deskewed.rays), scan.critical};
  for (int& index : result.critical) index = deskewed.index_of[static_cast<std::size_t>(index)];
  std::sort(result.critical.begin(), result.critical.end());
  return result;
}

ValidRays Deskew(const ValidRays& rays, const Twist& twist) {
  return rays.time_s.empty() ? rays : DeskewAndSort(rays, twist).rays;
}

}  // namespace crsm
