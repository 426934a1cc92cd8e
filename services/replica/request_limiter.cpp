#include "services/replica/request_limiter.hpp"

#include <algorithm>
#include <utility>

namespace crsm {
namespace {

constexpr auto kLookPeriod = std::chrono::seconds(1);

}  // namespace

RequestLimiter::RequestLimiter(std::function<bool(const Sender&)> comes_first)
    : comes_first_(std::move(comes_first)), look_limiter_(kLookPeriod) {}

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
  auto asker = std::ranges::find_if(
      askers_, [&](const Asker& each) { return each.sender == sender && each.requester == requester; });
  bool comes_first = asker != askers_.end() && asker->comes_first;
  if (!comes_first && sender.known() && look_limiter_.MayLook(sender, now)) comes_first = comes_first_(sender);
  if (asker == askers_.end()) {
    std::erase_if(askers_, [now](const Asker& each) { return now - each.last_asked > kForgotten; });
    if (!comes_first && std::ranges::count(askers_, false, &Asker::comes_first) == kMostAskers) return nullptr;
    asker = askers_.insert(askers_.end(), {.sender = sender, .requester = requester, .last_asked = now});
  }
  asker->comes_first = comes_first;
  return &*asker;
}

double RequestLimiter::Share(const Asker& asker) const {
  const auto others = static_cast<double>(std::ranges::count(askers_, false, &Asker::comes_first));
  return asker.comes_first ? 1.0 : std::min(1.0, kShared / others);
}

}  // namespace crsm
