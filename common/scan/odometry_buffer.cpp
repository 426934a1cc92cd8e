#include "common/scan/odometry_buffer.hpp"

#include <algorithm>

#include "common/math/trigonometry.hpp"

namespace crsm {
namespace {

/// Time from a moment to a later one.
std::uint64_t Gap_us(std::int64_t from, std::int64_t to) {
  return static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from);  // no overflow, whatever the two are
}

Pose2 Interpolate(const Pose2& from, const Pose2& to, double fraction) {
  return {from.x_m + fraction * (to.x_m - from.x_m), from.y_m + fraction * (to.y_m - from.y_m),
          from.yaw_rad + fraction * WrapAngle(to.yaw_rad - from.yaw_rad)};
}

}  // namespace

void OdometryBuffer::Add(const Odometry& sample) {
  if (sample.utime <= latest_utime_) {
    std::erase_if(samples_, [&](const Odometry& earlier) { return earlier.utime == sample.utime; });
  }
  latest_utime_ = std::max(latest_utime_, sample.utime);
  samples_.push_back(sample);
  if (samples_.size() > most_) samples_.pop_front();
}

ScanOdometry OdometryBuffer::FindExact(std::int64_t utime) const {
  const auto found =
      std::find_if(samples_.begin(), samples_.end(), [utime](const Odometry& sample) { return sample.utime == utime; });
  if (found == samples_.end()) return {};
  return {found->T_odom_robot ? ScanOdometry::State::kKnown : ScanOdometry::State::kNone, found->T_odom_robot};
}

ScanOdometry OdometryBuffer::Find(std::int64_t utime) const {
  if (const ScanOdometry exact = FindExact(utime); exact.state != ScanOdometry::State::kAwaited) return exact;
  const Odometry* before = nullptr;
  const Odometry* after = nullptr;
  for (const Odometry& sample : samples_) {
    if (!sample.T_odom_robot) continue;
    if (sample.utime < utime && (!before || sample.utime > before->utime)) before = &sample;
    if (sample.utime > utime && (!after || sample.utime < after->utime)) after = &sample;
  }
  const bool enclosed =
      before && after && Gap_us(before->utime, utime) <= kFurthest_us && Gap_us(utime, after->utime) <= kFurthest_us;
  if (!enclosed) {
    const bool passed = !samples_.empty() && samples_.back().utime > utime;
    return {passed ? ScanOdometry::State::kNone : ScanOdometry::State::kAwaited};
  }
  const double fraction =
      static_cast<double>(Gap_us(before->utime, utime)) / static_cast<double>(Gap_us(before->utime, after->utime));
  return {ScanOdometry::State::kKnown,
          RoundOdometry(Interpolate(*before->T_odom_robot, *after->T_odom_robot, fraction))};
}

}  // namespace crsm
