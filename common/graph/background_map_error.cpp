#include "common/graph/background_map_error.hpp"

#include <utility>

namespace crsm {

std::optional<MapError> BackgroundMapError::Find(const std::function<KnownMotions()>& collect) {
  constexpr int kLeast = 20;  // an estimate may take a twentieth of a core
  if (running_.valid() && running_.wait_for(Clock::duration::zero()) == std::future_status::ready) {
    const Estimate estimate = running_.get();
    latest_ = estimate.error;
    next_ = Clock::now() + kLeast * estimate.took;
  }
  if (!running_.valid() && Clock::now() >= next_) {
    running_ = std::async(std::launch::async, [motions = collect()] {
      const Clock::time_point start = Clock::now();
      const std::optional<MapError> error = EstimateMapError(motions, {}, false);
      return Estimate{error, Clock::now() - start};
    });
  }
  return latest_;
}

}  // namespace crsm
