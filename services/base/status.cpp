#include "services/base/status.hpp"

#include <algorithm>

namespace crsm {

void Latency::Record(double latency_ms) {
  recent_ms_[static_cast<std::size_t>(num_recorded_++) % recent_ms_.size()] = latency_ms;
  max_ms_ = std::max(max_ms_, latency_ms);
}

double Latency::Percentile(double share) const {
  const auto num = std::min(static_cast<std::size_t>(num_recorded_), recent_ms_.size());
  if (num == 0) return 0.0;
  std::vector<double> sorted(recent_ms_.begin(), recent_ms_.begin() + static_cast<std::ptrdiff_t>(num));
  const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(num - 1));
  std::nth_element(sorted.begin(), nth, sorted.end());
  return *nth;
}

}  // namespace crsm
