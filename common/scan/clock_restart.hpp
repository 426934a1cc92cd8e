#pragma once

#include <cstdint>

namespace crsm {

/// When a clock has begun anew.
struct ClockConstants {
  std::uint64_t hiccup_us = 8'000'000;  ///< by which clocks step back by accident: as the gap that ends a trajectory
};

/// Whether the clock of a laser has begun anew between two scans that came one after the other: it steps back by more
/// than clocks do by accident. The clock of the log intel steps back by up to 0.9 s. Utimes in microseconds.
inline bool HasClockRestarted(std::int64_t utime_before, std::int64_t utime, const ClockConstants& constants = {}) {
  if (utime >= utime_before) return false;
  return static_cast<std::uint64_t>(utime_before) - static_cast<std::uint64_t>(utime) > constants.hiccup_us;
}

}  // namespace crsm
