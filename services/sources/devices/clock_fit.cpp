#include "services/sources/devices/clock_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace crsm {

/// Of the edge of the lower hull at the arrivals' mean: us of the host for one of the laser.
double ClockFit::ComputeSlope() const {
  struct Point {
    double x, y;
  };
  std::vector<Point> hull;
  double mean_x = 0.0;
  for (const Arrival& arrival : arrivals_) {
    const Point next{static_cast<double>(arrival.device_us - arrivals_.front().device_us),
                     static_cast<double>(arrival.arrival_us - arrivals_.front().arrival_us)};
    mean_x += next.x / static_cast<double>(arrivals_.size());
    const auto IsAbove = [&](const Point& a, const Point& b) {
      return (b.x - a.x) * (next.y - a.y) <= (b.y - a.y) * (next.x - a.x);
    };
    while (hull.size() >= 2 && IsAbove(hull[hull.size() - 2], hull.back())) hull.pop_back();
    hull.push_back(next);
  }
  for (std::size_t i = 0; i + 1 < hull.size(); ++i) {
    if (hull[i + 1].x >= mean_x && hull[i + 1].x > hull[i].x) {
      const double slope = (hull[i + 1].y - hull[i].y) / (hull[i + 1].x - hull[i].x);
      return std::clamp(slope, 1.0 - largest_error_, 1.0 + largest_error_);
    }
  }
  return 1.0;
}

std::int64_t ClockFit::Fit(std::int64_t device_us, std::int64_t arrival_us) {
  constexpr std::size_t kMostArrivals = 256;
  constexpr std::int64_t kLongestDelay_us = 10'000'000;  // of a host that does nothing
  if (!arrivals_.empty()) {
    const Arrival& last = arrivals_.back();
    const std::int64_t ahead_us = (device_us - last.device_us) - (arrival_us - last.arrival_us);
    if (device_us <= last.device_us || std::abs(ahead_us) > kLongestDelay_us) Restart();
  }
  const std::int64_t passed_us = arrivals_.empty() ? 0 : device_us - last_device_us_;
  arrivals_.push_back({device_us, arrival_us});
  if (arrivals_.size() > kMostArrivals) arrivals_.pop_front();

  const double slope = ComputeSlope();
  double earliest_us = 0.0;  // after arrival_us: the newest arrival is on no line above 0
  for (const Arrival& arrival : arrivals_) {
    const double at_now_us = static_cast<double>(arrival.arrival_us - arrival_us) +
                             slope * static_cast<double>(device_us - arrival.device_us);
    earliest_us = std::min(earliest_us, at_now_us);
  }
  const std::int64_t fitted_us = arrival_us + std::llround(earliest_us);
  const std::int64_t soonest_us = last_utime_ + std::max<std::int64_t>(1, passed_us / 2);
  last_device_us_ = device_us;
  return last_utime_ = std::max(fitted_us, soonest_us);
}

}  // namespace crsm
