// botlab.lidar_t of the University of Michigan's student robots, in both of its spellings: the older logs call the
// count of the beams nranges.
//
// The beams have angles of their own, clockwise and uneven. Each goes to the nearest of 1440 beams, 0.25 deg apart and
// clockwise from the first one, in the order in which they were measured: its angle is off by 0.125 deg at most. Of two
// on one beam the nearer counts; beams that nothing falls on are 0 = no return.

#include <algorithm>
#include <botlab/lidar_nranges_t.hpp>
#include <botlab/lidar_t.hpp>
#include <cmath>

#include "common/math/trigonometry.hpp"
#include "services/sources/laser_types.hpp"

namespace crsm {
namespace {

/// The two types differ in nothing but the name of the count.
template <class Lidar>
constexpr auto LidarFields(std::int32_t Lidar::*count) {
  return std::tuple(&Lidar::utime, count, Array(&Lidar::ranges, count, kMaxBeams),
                    Array(&Lidar::thetas, count, kMaxBeams), Array(&Lidar::times, count, kMaxBeams),
                    Array(&Lidar::intensities, count, kMaxBeams));
}

template <class Lidar>
bool LidarInRange(const Lidar& lidar) {
  constexpr double kFullTurn_rad = 2.0 * kPi + 1e-3;  // angles travel in single precision
  const auto is_angle = [](float theta_rad) { return std::abs(theta_rad) <= kFullTurn_rad; };  // false for NaN
  return lidar.utime >= 0 && lidar.ranges.size() >= kMinBeams &&
         std::all_of(lidar.thetas.begin(), lidar.thetas.end(), is_angle);
}

template <class Lidar>
LaserScan ToScan(const Lidar& lidar) {
  constexpr int kGridBeams = 1440;
  constexpr double kStep_rad = 2.0 * kPi / kGridBeams;
  const double first_rad = lidar.thetas.front();
  LaserScan scan{lidar.utime, static_cast<float>(WrapAngle(-first_rad)), static_cast<float>(-kStep_rad),
                 std::vector<float>(kGridBeams, 0.0f)};
  for (std::size_t i = 0; i < lidar.ranges.size(); ++i) {
    const float range_m = lidar.ranges[i];
    if (!(range_m > 0.0f)) continue;
    const long steps = std::lround((lidar.thetas[i] - first_rad) / kStep_rad) % kGridBeams;
    float& nearest_m = scan.ranges_m[static_cast<std::size_t>(steps < 0 ? steps + kGridBeams : steps)];
    if (nearest_m == 0.0f || range_m < nearest_m) nearest_m = range_m;
  }
  return scan;
}

}  // namespace

template <>
constexpr auto FieldsOf<botlab::lidar_t>() {
  return LidarFields(&botlab::lidar_t::num_ranges);
}

template <>
constexpr auto FieldsOf<botlab::lidar_nranges_t>() {
  return LidarFields(&botlab::lidar_nranges_t::nranges);
}

template <>
bool ValuesInRange(const botlab::lidar_t& lidar) {
  return LidarInRange(lidar);
}

template <>
bool ValuesInRange(const botlab::lidar_nranges_t& lidar) {
  return LidarInRange(lidar);
}

namespace {

[[maybe_unused]] const bool kRegistered = RegisterLaserType<botlab::lidar_t>("botlab.lidar_t", &ToScan) &&
                                          RegisterLaserType<botlab::lidar_nranges_t>("botlab.lidar_t", &ToScan);

}  // namespace
}  // namespace crsm
