#pragma once

#include <cstdint>
#include <optional>

namespace crsm {

/// A counter of few bits, made one that goes on.
class WrappingClock {
 public:
  struct Reading {
    std::int64_t total;
    bool restarted;  ///< the counter went back: the laser was started anew
  };

  /// period: what the counter never reaches.
  explicit WrappingClock(std::int64_t period) : period_(period) {}

  /// A step by less than half the period is one forward, maybe over the end of the counter; else it went back.
  Reading Read(std::int64_t count) {
    const std::int64_t step = last_ ? ((count - *last_) % period_ + period_) % period_ : 0;
    const bool restarted = step >= period_ / 2;
    if (!restarted) total_ += step;
    last_ = count;
    return {total_, restarted};
  }

 private:
  std::int64_t period_;
  std::optional<std::int64_t> last_;
  std::int64_t total_ = 0;
};

}  // namespace crsm
