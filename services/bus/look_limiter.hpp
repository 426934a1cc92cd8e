#pragma once

#include <chrono>
#include <cstddef>
#include <map>

#include "services/bus/sender.hpp"

namespace crsm {

/// How often senders are looked at, which takes system calls: each of them once in a while, and so many at a time. A
/// flood from many ports is not looked at packet by packet, and shuts no sender out for longer than it lasts.
class LookLimiter {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMostSenders = 1000;

  explicit LookLimiter(Clock::duration period) : period_(period) {}

  bool MayLook(const Sender& sender, Clock::time_point now);

 private:
  Clock::duration period_;
  std::map<Sender, Clock::time_point> next_looks_;
};

}  // namespace crsm
