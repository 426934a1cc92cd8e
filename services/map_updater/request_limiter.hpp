#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "services/bus/sole_sender.hpp"

namespace crsm {

/// How many MAP_REQUEST are answered. A page takes a small question and much work: without a limit, who asks on and on
/// keeps the owner of the map from mapping.
class RequestLimiter {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kPerSecond = 200.0;    ///< pages for one asker
  static constexpr double kAtOnce = 400.0;       ///< of them after a pause: the whole of a map of 3,000 tiles
  static constexpr std::size_t kMostAskers = 8;  ///< others have to wait; so all together are limited too
  static constexpr auto kForgotten = std::chrono::seconds(10);  ///< an asker that has not asked for as long

  /// Whether a request is to be answered. An asker is a sender, or where that is not known, a requester.
  bool Admit(const Sender& sender, std::int64_t requester, Clock::time_point now);

 private:
  struct Asker {
    Sender sender;
    std::int64_t requester;  ///< 0 where the sender is known
    double left = kAtOnce;   ///< pages that may be asked for now
    Clock::time_point last_asked;
  };
  Asker* Find(const Sender& sender, std::int64_t requester, Clock::time_point now);

  std::vector<Asker> askers_;
};

}  // namespace crsm
