#include "services/bus/look_limiter.hpp"

namespace crsm {

bool LookLimiter::MayLook(const Sender& sender, Clock::time_point now) {
  if (next_looks_.size() >= kMostSenders)
    std::erase_if(next_looks_, [now](const auto& look) { return look.second <= now; });
  const auto known = next_looks_.find(sender);
  if (known == next_looks_.end())
    return next_looks_.size() < kMostSenders && next_looks_.emplace(sender, now + period_).second;
  if (now < known->second) return false;
  known->second = now + period_;
  return true;
}

}  // namespace crsm
