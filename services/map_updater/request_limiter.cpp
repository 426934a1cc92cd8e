#include "services/map_updater/request_limiter.hpp"

#include <algorithm>

namespace crsm {
namespace {

constexpr auto kLookPeriod = std::chrono::seconds(1);

}  // namespace

bool RequestLimiter::Admit(const Sender& sender, std::int64_t requester, Clock::time_point now) {
  Asker* asker = Find(sender, sender.known() ? 0 : requester, now);
  if (!asker) return false;
  const double elapsed_s = std::chrono::duration<double>(now - asker->last_asked).count();
  const double share = Share(*asker);
  asker->left = std::min(share * kAtOnce, asker->left + share * kPerSecond * elapsed_s);
  asker->last_asked = now;
  if (asker->left < 1.0) return false;
  asker->left -= 1.0;
  return true;
}

RequestLimiter::Asker* RequestLimiter::Find(const Sender& sender, std::int64_t requester, Clock::time_point now) {
  const auto found = std::ranges::find_if(
      askers_, [&](const Asker& asker) { return asker.sender == sender && asker.requester == requester; });
  if (found != askers_.end()) {
    if (!found->comes_first && sender.known() && now >= found->next_look) {
      found->next_look = now + kLookPeriod;
      found->comes_first = comes_first_(sender);
    }
    return &*found;
  }
  std::erase_if(askers_, [now](const Asker& asker) { return now - asker.last_asked > kForgotten; });
  const bool comes_first = Look(sender, now);
  if (!comes_first && std::ranges::count(askers_, false, &Asker::comes_first) == kMostAskers) return nullptr;
  return &askers_.emplace_back(Asker{sender, requester, comes_first, now, kAtOnce, now});
}

/// A flood from many ports is not looked at packet by packet; one that was not seen asks again.
bool RequestLimiter::Look(const Sender& sender, Clock::time_point now) {
  constexpr auto kPause = std::chrono::milliseconds(50);
  Clock::time_point& next = next_looks_[sender.port % next_looks_.size()];
  if (!sender.known() || now < next) return false;
  next = now + kPause;
  return comes_first_(sender);
}

double RequestLimiter::Share(const Asker& asker) const {
  const auto others = static_cast<double>(std::ranges::count(askers_, false, &Asker::comes_first));
  return asker.comes_first ? 1.0 : std::min(1.0, kShared / others);
}

}  // namespace crsm
