#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include "services/bus/look_limiter.hpp"
#include "services/bus/sender.hpp"

namespace crsm {

/// How many requests are answered. A page takes a small question and much work: without a limit, who asks on and on
/// keeps the owner of the map from mapping. Those that mapping waits for, the matcher say, come first: others take
/// nothing from them.
class RequestLimiter {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kPerSecond = 200.0;     ///< answers for one asker at most ...
  static constexpr double kAtOnce = 400.0;        ///< ... of them after a pause: the whole of a map of 3,000 tiles
  static constexpr double kShared = 8.0;          ///< so many times as much for all together, in equal parts
  static constexpr std::size_t kMostAskers = 64;  ///< others have to wait
  static constexpr auto kForgotten = std::chrono::seconds(10);  ///< an asker that has not asked for as long

  /// comes_first: whether a sender is one that mapping waits for. It is asked seldom: it takes system calls.
  explicit RequestLimiter(std::function<bool(const Sender&)> comes_first);

  /// Whether a request is to be answered. An asker is a sender, or where that is not known, a requester.
  bool Admit(const Sender& sender, std::int64_t requester, Clock::time_point now);

 private:
  struct Asker {
    Sender sender;
    std::int64_t requester;  ///< 0 where the sender is known
    bool comes_first = false;
    double left = kAtOnce;  ///< answers that it may have now
    Clock::time_point last_asked;
  };
  Asker* Find(const Sender& sender, std::int64_t requester, Clock::time_point now);
  /// Of what one asker alone may have.
  double Share(const Asker& asker) const;

  std::function<bool(const Sender&)> comes_first_;
  std::vector<Asker> askers_;
  LookLimiter look_limiter_;  ///< at who comes first: it may have become what mapping waits for
};

}  // namespace crsm
