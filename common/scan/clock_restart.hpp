#pragma once

#include <cstdint>

namespace crsm {

/// Whether the clock of a laser has begun anew between two scans that came one after the other: it steps back by more
/// than clocks do by accident. The clock of the log intel steps back by up to 0.9 s. Utimes in microseconds.
inline bool HasClockRestarted(std::int64_t utime_before, std::int64_t utime) {
  constexpr std::uint64_t kHiccup_us = 8'000'000;  // as the gap that ends a trajectory
  if (utime >= utime_before) return false;
  return static_cast<std::uint64_t>(utime_before) - static_cast<std::uint64_t>(utime) > kHiccup_us;
}

}  // namespace crsm
