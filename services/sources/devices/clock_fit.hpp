#pragma once

#include <cstdint>
#include <deque>

namespace crsm {

/// The host's time of what a laser stamped by a clock of its own, from when its bytes arrived.
///
/// A scan may come late by any delay, of the host above all, but never early: the line that leads from the laser's
/// clock to the host's lies below all arrivals of the last 256 scans, as close to them as it can. It is an edge of the
/// lower hull of the arrivals, the one at their mean.
class ClockFit {
 public:
  /// largest_error: by how much the laser's clock may be too fast or too slow, as a share.
  explicit ClockFit(double largest_error) : largest_error_(largest_error) {}

  /// When by the host's clock [us] the laser's said `device_us`; `arrival_us` is when this came. Later than what was
  /// returned before, if only by half of what has passed on the laser's clock, or by 1 us.
  std::int64_t Fit(std::int64_t device_us, std::int64_t arrival_us);

  /// The laser's clock has begun anew, stood still, or said something wrong; the host's time goes on. Fit finds that
  /// out where the two clocks go apart by more than ten seconds from one scan to the next.
  void Restart() { arrivals_.clear(); }

 private:
  struct Arrival {
    std::int64_t device_us;
    std::int64_t arrival_us;
  };

  double ComputeSlope() const;

  double largest_error_;
  std::deque<Arrival> arrivals_;
  std::int64_t last_device_us_ = 0;
  std::int64_t last_utime_ = 0;
};

}  // namespace crsm
