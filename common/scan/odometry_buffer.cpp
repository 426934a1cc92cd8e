#include "common/scan/odometry_buffer.hpp"

#include <algorithm>

#include "common/math/trigonometry.hpp"
#include "common/scan/clock_restart.hpp"

namespace crsm {
namespace {

/// Time from a moment to a later one.
std::uint64_t Gap_us(std::int64_t from, std::int64_t to) {
  return static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from);  // no overflow, whatever the two are
}

std::optional<Pose2> Interpolate(const Odometry& from, const Odometry& to, std::int64_t utime) {
  const double fraction =
      static_cast<double>(Gap_us(from.utime, utime)) / static_cast<double>(Gap_us(from.utime, to.utime));
  const Pose2& start = *from.T_odom_robot;
  const Pose2& end = *to.T_odom_robot;
  return RoundOdometry({start.x_m + fraction * (end.x_m - start.x_m), start.y_m + fraction * (end.y_m - start.y_m),
                        start.yaw_rad + fraction * WrapAngle(end.yaw_rad - start.yaw_rad)});
}

}  // namespace

void OdometryBuffer::Add(const Odometry& sample) {
  if (!samples_.empty() && HasClockRestarted(samples_.back().utime, sample.utime)) samples_.clear();
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
  const bool passed = !samples_.empty() && samples_.back().utime > utime;
  const ScanOdometry not_known{passed ? ScanOdometry::State::kNone : ScanOdometry::State::kAwaited};
  const auto furthest_us = static_cast<std::uint64_t>(constants_.furthest_us);
  const Odometry* next = nullptr;  // by arrival
  for (auto sample = samples_.rbegin(); sample != samples_.rend(); ++sample) {
    if (!sample->T_odom_robot) continue;
    const bool next_is_near = next && next->utime > utime && Gap_us(utime, next->utime) <= furthest_us;
    if (sample->utime < utime && Gap_us(sample->utime, utime) <= furthest_us) {
      if (!next) return not_known;
      if (!next_is_near) return {ScanOdometry::State::kNone};
      return {ScanOdometry::State::kKnown, Interpolate(*sample, *next, utime)};
    }
    if (next_is_near && sample->utime > next->utime)
      return {ScanOdometry::State::kNone};  // utimes stepped back between
    next = &*sample;
  }
  return not_known;
}

}  // namespace crsm
