#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace crsm {

/// Lets lines of one kind through to the terminal: some at once, and then one now and then.
class LineLimit {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kAtOnce = 10.0;    ///< lines after a pause
  static constexpr double kPerSecond = 0.1;  ///< lines when there are more

  /// The line, with how many were left out before it; nothing if it is one of those.
  std::optional<std::string> Pass(std::string line, Clock::time_point now);

 private:
  double left_ = kAtOnce;  ///< lines that may be said now
  std::int64_t num_left_out_ = 0;
  Clock::time_point last_{};
};

}  // namespace crsm
