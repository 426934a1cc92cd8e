#pragma once

#include <algorithm>
#include <chrono>

namespace crsm {

/// When to send once more what was not answered: after a pause that doubles each time, up to a longest one, so that a
/// slow network is not flooded. Progress makes the pause short again.
class Backoff {
 public:
  using Clock = std::chrono::steady_clock;

  /// Pauses grow no longer: on a network that loses every third answer, 5 s hold ten tries and more.
  static constexpr Clock::duration kLongest = std::chrono::milliseconds(500);

  /// longest: where it is shorter than `first`, every pause is `first`.
  explicit Backoff(Clock::duration first, Clock::duration longest = kLongest)
      : first_(first), longest_(std::max(first, longest)) {}

  /// It was sent just now, for the first time: due after the first pause.
  void Restart(Clock::time_point now) {
    pause_ = first_;
    Advance(now);
  }
  /// There is something new to send: due at once.
  void RestartAtOnce() {
    pause_ = first_;
    next_ = {};
  }

  /// Whether it is to be sent now. If so, the next pause begins.
  bool Due(Clock::time_point now) {
    if (now < next_) return false;
    Advance(now);
    return true;
  }

 private:
  void Advance(Clock::time_point now) {
    next_ = now + pause_;
    pause_ = std::min(2 * pause_, longest_);
  }

  Clock::duration first_;
  Clock::duration longest_;
  Clock::duration pause_ = first_;
  Clock::time_point next_{};
};

}  // namespace crsm
