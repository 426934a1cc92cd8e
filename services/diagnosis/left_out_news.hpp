#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "common/logs/left_out.hpp"

namespace crsm {

/// In the matcher's line about scans that it has seen before: run_stack finds it in the log by this.
inline constexpr const char* kUtimeRepeated = "repeat the utime of an earlier scan and are left out";

/// Tells a live process when to say that scans are left out: from three on, if they are worth a word (left_out.hpp)
/// among those since the last time, and once a minute at most.
class LeftOutNews {
 public:
  using Time = std::chrono::steady_clock::time_point;

  struct News {
    std::int64_t num_left_out;
    std::int64_t num_all;
  };

  /// A scan came that can be used.
  void Take() { ++num_all_; }

  /// One came that cannot. What is to be said of it now, if anything.
  std::optional<News> LeaveOut(Time now) {
    constexpr std::int64_t kEnough = 3;  // one stray message proves nothing
    constexpr auto kPause = std::chrono::minutes(1);
    ++num_all_;
    if (++num_left_out_ < kEnough || now < next_ || !IsWorthSaying(num_left_out_, num_all_)) return std::nullopt;
    const News news{num_left_out_, num_all_};
    next_ = now + kPause;
    num_left_out_ = num_all_ = 0;
    return news;
  }

 private:
  std::int64_t num_left_out_ = 0;  ///< since it was said last
  std::int64_t num_all_ = 0;       ///< likewise
  Time next_{};
};

}  // namespace crsm
