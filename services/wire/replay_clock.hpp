#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

namespace crsm {

/// Times for what is recorded, such that players can play it: those of the messages, except that where their clock
/// steps back no time passes, and where it jumps ahead a minute does.
class ReplayClock {
 public:
  /// utime: of the next message, by its own clock [us], 0 or later. Returns the time at which it is to be played.
  std::int64_t Follow(std::int64_t utime) {
    constexpr std::int64_t kLongestGap_us = 60'000'000;
    const auto before = std::exchange(last_, utime);
    const std::int64_t gap = before ? std::clamp<std::int64_t>(utime - *before, 0, kLongestGap_us) : utime;
    now_ += std::min(gap, std::numeric_limits<std::int64_t>::max() - now_);
    return now_;
  }

  std::int64_t now() const { return now_; }

 private:
  std::optional<std::int64_t> last_;
  std::int64_t now_ = 0;
};

}  // namespace crsm
