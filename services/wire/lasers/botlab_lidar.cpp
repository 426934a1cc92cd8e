// botlab.lidar_t of the University of Michigan's student robots, in both of its spellings: the older logs call the
// count of the beams nranges.
//
// The beams have angles of their own, uneven, and clockwise or, in today's mbot, counter-clockwise: the message does
// not tell which (--botlab-clockwise): PolarGrid.
//
// The beams have times, too. Where these are a sweep's, the scan's utime is that of the last one, the moment for which
// botlab's own programs say their poses; the utime of the message is that of the first one, or of the last.

#include <algorithm>
#include <cmath>
#include <wire_fields/botlab/lidar_nranges_t.hpp>
#include <wire_fields/botlab/lidar_t.hpp>

#include "common/math/trigonometry.hpp"
#include "services/wire/laser_types.hpp"
#include "services/wire/polar_grid.hpp"

namespace crsm {
namespace {

static_assert(MostOf(&botlab::lidar_t::num_ranges) == kMaxBeams);
static_assert(MostOf(&botlab::lidar_nranges_t::nranges) == kMaxBeams);

template <class Lidar>
bool LidarInRange(const Lidar& lidar) {
  return lidar.utime >= 0 && lidar.ranges.size() >= kMinBeams &&
         std::all_of(lidar.thetas.begin(), lidar.thetas.end(), IsWithinFullTurn);
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
LaserScan ToScan(const Lidar& lidar, const LaserMessageOptions& options) {
  const bool has_times = AreOfSweep(lidar.times);
  const std::vector<std::int64_t> times =
      has_times ? PutInOrder(lidar.times, options.botlab_clockwise) : std::vector<std::int64_t>(lidar.ranges.size());
  const auto sense = options.botlab_clockwise ? PolarGrid::Sense::kClockwise : PolarGrid::Sense::kCounterClockwise;
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
