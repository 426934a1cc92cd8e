// botlab.lidar_t of the University of Michigan's student robots, in both of its spellings: the older logs call the
// count of the beams nranges.
//
// The beams have angles of their own, uneven, and clockwise or, in today's mbot, counter-clockwise: the message does
// not tell which (--botlab-clockwise): PolarGrid.
//
// The beams have times, too. Where these are a sweep's, the scan's utime is that of the last one, the moment for which
// botlab's own programs say their poses; the utime of the message is that of the first one, or of the last.

#include <algorithm>
#include <botlab/lidar_nranges_t.hpp>
#include <botlab/lidar_t.hpp>
#include <cmath>

#include "common/math/trigonometry.hpp"
#include "services/wire/laser_types.hpp"
#include "services/wire/polar_grid.hpp"

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

/// Whether times are those of a sweep [us], and not zeros, or from different clocks.
bool AreOfSweep(const std::vector<std::int64_t>& times) {
  constexpr std::uint64_t kLongest_us = 1'000'000;
  return times.front() >= 0 && std::is_sorted(times.begin(), times.end()) && times.front() < times.back() &&
         static_cast<std::uint64_t>(times.back()) - static_cast<std::uint64_t>(times.front()) <= kLongest_us;
}

/// Whether the times were not measured but counted out evenly.
bool AreEven(const std::vector<std::int64_t>& times) {
  const std::int64_t gap_us = times[1] - times[0];
  return std::adjacent_find(times.begin(), times.end(), [gap_us](std::int64_t one, std::int64_t next) {
           return next - one != gap_us;
         }) == times.end();
}

/// The times of a sweep's beams, each in its place.
std::vector<std::int64_t> PutInOrder(std::vector<std::int64_t> times, bool clockwise) {
  // The driver of today's mbot sorts the beams by their angles and numbers their times afterwards; but an RPLidar turns
  // clockwise, whatever its angles are called.
  if (!clockwise && AreEven(times)) std::reverse(times.begin(), times.end());
  return times;
}

template <class Lidar>
LaserScan ToScan(const Lidar& lidar, const ScanParameters& parameters) {
  const bool has_times = AreOfSweep(lidar.times);
  const std::vector<std::int64_t> times =
      has_times ? PutInOrder(lidar.times, parameters.botlab_clockwise) : std::vector<std::int64_t>(lidar.ranges.size());
  const auto sense = parameters.botlab_clockwise ? PolarGrid::Sense::kClockwise : PolarGrid::Sense::kCounterClockwise;
  PolarGrid grid(lidar.thetas.front(), sense, has_times);
  const std::int64_t end = has_times ? lidar.times.back() : 0;
  for (std::size_t i = 0; i < lidar.ranges.size(); ++i) {
    grid.Add(lidar.thetas[i], lidar.ranges[i], 1e-6f * static_cast<float>(times[i] - end));
  }
  LaserScan scan = grid.TakeScan();
  scan.utime = has_times ? end : lidar.utime;
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
