#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/parameters.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

constexpr std::int64_t kRosSecond_ns = 1'000'000'000;

/// A time as ROS has it: whole seconds since 1970, and nanoseconds since the last of them.
struct RosTime {
  std::int64_t sec = 0;
  std::int64_t nanosec = 0;
};

/// The same, rounded [us].
std::int64_t ToUtime(const RosTime& time);

/// A scan as ROS has it, whichever way its message came; fields have the names and meanings of sensor_msgs/LaserScan.
struct RosScan {
  RosTime stamp;  ///< of the first beam
  float angle_min = 0.0f;
  float angle_max = 0.0f;
  float angle_increment = 0.0f;
  float time_increment = 0.0f;
  float range_min = 0.0f;
  float range_max = 0.0f;
  std::vector<float> ranges;
};

/// Where angle_max and angle_increment tell opposite senses of rotation: that, and what mends it. Else empty.
std::string DescribeContradiction(const RosScan& scan);

/// The same as LASER has it. Its utime is that of the beam that was measured last, and each beam has its time, where
/// time_increment tells; without it, and where a sweep would take more than a second, utime is the stamp. Negative
/// increments are those of a laser that hangs upside down, whose driver turns its scans round. angle_max is not used.
///
/// Ranges outside of what the message calls its range, infinity and NaN are 0 = no return; so is one that is range_max
/// itself, which simulators and older drivers set for it. Limits that cannot be, as 0 to 0, are none.
///
/// parameters: where they do not believe the times of beams, the beams have none, and utime is the stamp and their
/// sweep_s.
LaserScan FromRosScan(RosScan ros, const ScanParameters& parameters = {});

}  // namespace crsm
