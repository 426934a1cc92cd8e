// sensor_msgs.LaserScan: a scan as ROS has it, where its messages travel by LCM, as in dimos on
// /scan#sensor_msgs.LaserScan.

#include <algorithm>
#include <cmath>
#include <wire_fields/sensor_msgs/LaserScan.hpp>

#include "common/math/trigonometry.hpp"
#include "services/wire/laser_types.hpp"
#include "services/wire/ros_scan.hpp"

namespace crsm {

static_assert(MostOf(&sensor_msgs::LaserScan::ranges_length) == kMostBeamsRead);

template <>
bool ValuesInRange(const sensor_msgs::LaserScan& scan) {
  constexpr double kFullTurn_rad = 2.0 * kPi + 1e-3;  // angles travel in single precision
  const double sweep_rad = static_cast<double>(scan.angle_increment) * std::max(0, scan.ranges_length - 1);
  const auto& stamp = scan.header.stamp;
  return stamp.sec >= 0 && stamp.nsec >= 0 && stamp.nsec < kRosSecond_ns && scan.ranges.size() >= kMinBeams &&
         std::abs(scan.angle_min) <= kFullTurn_rad && std::abs(sweep_rad) <= kFullTurn_rad &&  // false for NaN
         scan.angle_increment != 0.0f &&
         (scan.intensities_length == 0 || scan.intensities_length == scan.ranges_length);
}

namespace {

LaserScan ToScan(const sensor_msgs::LaserScan& m, const LaserMessageOptions& options) {
  return FromRosScan({{m.header.stamp.sec, m.header.stamp.nsec},
                      m.angle_min,
                      m.angle_increment,
                      m.time_increment,
                      m.range_min,
                      m.range_max,
                      m.ranges},
                     options.scan);
}

std::string FrameOf(const sensor_msgs::LaserScan& scan) { return scan.header.frame_id; }

[[maybe_unused]] const bool kRegistered =
    RegisterLaserType<sensor_msgs::LaserScan>("sensor_msgs.LaserScan", &ToScan, &FrameOf);

}  // namespace
}  // namespace crsm
