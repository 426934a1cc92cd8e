// sensor_msgs.LaserScan: a scan as ROS has it, where its messages travel by LCM, as in dimos on
// /scan#sensor_msgs.LaserScan.

#include <wire_fields/sensor_msgs/LaserScan.hpp>

#include "services/wire/laser_types.hpp"
#include "services/wire/ros_scan.hpp"

namespace crsm {

static_assert(MostOf(&sensor_msgs::LaserScan::ranges_length) == kMostBeamsRead);

template <>
bool ValuesInRange(const sensor_msgs::LaserScan& scan) {
  const auto& stamp = scan.header.stamp;
  return stamp.sec >= 0 && stamp.nsec >= 0 && stamp.nsec < kRosSecond_ns &&
         AreBeamAngles(scan.angle_min, scan.angle_increment, scan.ranges.size()) &&
         (scan.intensities_length == 0 || scan.intensities_length == scan.ranges_length);
}

namespace {

RosScan ToRosScan(const sensor_msgs::LaserScan& m) {
  return {{m.header.stamp.sec, m.header.stamp.nsec},
          m.angle_min,
          m.angle_max,
          m.angle_increment,
          m.time_increment,
          m.range_min,
          m.range_max,
          m.ranges};
}

LaserScan ToScan(const sensor_msgs::LaserScan& message, const LaserMessageOptions& options) {
  return FromRosScan(ToRosScan(message), options.scan);
}

std::string FrameOf(const sensor_msgs::LaserScan& message) { return message.header.frame_id; }

std::string ContradictionOf(const sensor_msgs::LaserScan& message) { return DescribeContradiction(ToRosScan(message)); }

[[maybe_unused]] const bool kRegistered =
    RegisterLaserType<sensor_msgs::LaserScan>("sensor_msgs.LaserScan", &ToScan, {&FrameOf, &ContradictionOf});

}  // namespace
}  // namespace crsm
