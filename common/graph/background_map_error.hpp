#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <optional>

#include "common/graph/map_error.hpp"

namespace crsm {

/// How far off a map may be, while it is being made: estimated on a thread of its own, as often as costs little.
class BackgroundMapError {
 public:
  /// What was known last; nothing before the first estimate. Begins a newer one, from what `collect` gives, if it is
  /// time for that.
  std::optional<MapError> Find(const std::function<KnownMotions()>& collect);

 private:
  using Clock = std::chrono::steady_clock;
  struct Estimate {
    std::optional<MapError> error;
    Clock::duration took;
  };

  std::future<Estimate> running_;
  std::optional<MapError> latest_;
  Clock::time_point next_;  ///< not before
};

}  // namespace crsm
