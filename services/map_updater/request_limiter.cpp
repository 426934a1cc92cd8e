#include "services/map_updater/request_limiter.hpp"

#include <algorithm>

namespace crsm {

bool RequestLimiter::Admit(const Sender& sender, std::int64_t requester, Clock::time_point now) {
  Asker* asker = Find(sender, sender.known() ? 0 : requester, now);
  if (!asker) return false;
  const double elapsed_s = std::chrono::duration<double>(now - asker->last_asked).count();
  asker->left = std::min(kAtOnce, asker->left + kPerSecond * elapsed_s);
  asker->last_asked = now;
  if (asker->left < 1.0) return false;
  asker->left -= 1.0;
  return true;
}

RequestLimiter::Asker* RequestLimiter::Find(const Sender& sender, std::int64_t requester, Clock::time_point now) {
  const auto found = std::find_if(askers_.begin(), askers_.end(), [&](const Asker& asker) {
    return asker.sender == sender && asker.requester == requester;
  });
  if (found != askers_.end()) return &*found;
  std::erase_if(askers_, [now](const Asker& asker) { return now - asker.last_asked > kForgotten; });
  if (askers_.size() == kMostAskers) return nullptr;
  return &askers_.emplace_back(Asker{sender, requester, kAtOnce, now});
}

}  // namespace crsm
