#include "common/logs/unique_utimes.hpp"

#include <limits>

#include "common/scan/clock_restart.hpp"

namespace crsm {

void UniqueUtimes::BeginDrive() {
  first_of_drive_ = utimes_.size();
  last_of_clock_.reset();
}

std::optional<std::int64_t> UniqueUtimes::Add(std::int64_t utime) {
  constexpr std::int64_t kMostMoved_us = 1000;
  if (last_of_clock_ && HasClockRestarted(*last_of_clock_, utime)) BeginDrive();
  last_of_clock_ = utime;
  for (std::int64_t moved_us = 0; moved_us < kMostMoved_us; ++moved_us) {
    const auto found = utimes_.Find(utime);
    if (!found) {
      utimes_.Add(utime);
      return utime;
    }
    if (*found >= first_of_drive_ || utime == std::numeric_limits<std::int64_t>::max()) return std::nullopt;
    ++utime;
  }
  return std::nullopt;
}

}  // namespace crsm
