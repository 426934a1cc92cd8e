// sensor_msgs.LaserScan: a scan as ROS has it, where its messages travel by LCM, as in dimos on
// /scan#sensor_msgs.LaserScan.
//
// The stamp is the moment of the first beam. Where the message says how long a beam takes (time_increment), the scan's
// utime is that of the last one, as everywhere here.

#include <algorithm>
#include <cmath>
#include <sensor_msgs/LaserScan.hpp>

#include "common/math/trigonometry.hpp"
#include "services/runtime/laser_types.hpp"

namespace crsm {

template <>
constexpr auto FieldsOf<std_msgs::Time>() {
  return std::tuple(&std_msgs::Time::sec, &std_msgs::Time::nsec);
}

template <>
constexpr auto FieldsOf<std_msgs::Header>() {
  return std::tuple(&std_msgs::Header::seq, &std_msgs::Header::stamp, &std_msgs::Header::frame_id);
}

template <>
constexpr auto FieldsOf<sensor_msgs::LaserScan>() {
  using T = sensor_msgs::LaserScan;
  return std::tuple(&T::ranges_length, &T::intensities_length, &T::header, &T::angle_min, &T::angle_max,
                    &T::angle_increment, &T::time_increment, &T::scan_time, &T::range_min, &T::range_max,
                    Array(&T::ranges, &T::ranges_length, kMaxBeams),
                    Array(&T::intensities, &T::intensities_length, kMaxBeams));
}

template <>
bool ValuesInRange(const sensor_msgs::LaserScan& scan) {
  constexpr double kFullTurn_rad = 2.0 * kPi + 1e-3;  // angles travel in single precision
  constexpr std::int32_t kSecond_ns = 1'000'000'000;
  const double sweep_rad = static_cast<double>(scan.angle_increment) * std::max(0, scan.ranges_length - 1);
  const auto& stamp = scan.header.stamp;
  return stamp.sec >= 0 && stamp.nsec >= 0 && stamp.nsec < kSecond_ns && scan.ranges.size() >= kMinBeams &&
         std::abs(scan.angle_min) <= kFullTurn_rad && std::abs(sweep_rad) <= kFullTurn_rad &&  // false for NaN
         scan.angle_increment != 0.0f &&
         (scan.intensities_length == 0 || scan.intensities_length == scan.ranges_length);
}

namespace {

/// Of the whole sweep [s]; 0 where the message does not say.
double SweepOf(const sensor_msgs::LaserScan& scan) {
  constexpr double kLongest_s = 1.0;
  const double sweep_s = static_cast<double>(scan.time_increment) * (scan.ranges_length - 1);
  return sweep_s > 0.0 && sweep_s <= kLongest_s ? sweep_s : 0.0;  // 0 for NaN
}

LaserScan ToScan(const sensor_msgs::LaserScan& message, const ScanParameters&) {
  const auto& stamp = message.header.stamp;
  const double sweep_s = SweepOf(message);
  LaserScan scan{std::int64_t{stamp.sec} * 1'000'000 + stamp.nsec / 1000 + std::llround(1e6 * sweep_s),
                 message.angle_min, message.angle_increment, message.ranges};
  const bool has_limits = message.range_min >= 0.0f && message.range_max > message.range_min;  // false for NaN
  for (float& range_m : scan.ranges_m) {
    if (has_limits && (range_m < message.range_min || range_m > message.range_max)) range_m = 0.0f;
  }
  for (int beam = 0; sweep_s > 0.0 && beam < message.ranges_length; ++beam) {
    scan.times_s.push_back(static_cast<float>(beam * static_cast<double>(message.time_increment) - sweep_s));
  }
  return scan;
}

[[maybe_unused]] const bool kRegistered = RegisterLaserType<sensor_msgs::LaserScan>("sensor_msgs.LaserScan", &ToScan);

}  // namespace
}  // namespace crsm
