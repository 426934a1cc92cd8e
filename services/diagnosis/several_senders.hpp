#pragma once

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <utility>

#include "services/bus/sender.hpp"

namespace crsm {

/// Finds out whether several senders send on one channel at the same time. One that takes the place of another that
/// has ended is no such case.
class SeveralSenders {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A message came. Two senders of the channel, where this one and another send by turns.
  std::optional<std::pair<Sender, Sender>> Hear(const Sender& sender, Time now) {
    constexpr auto kByTurns = std::chrono::seconds(2);
    constexpr std::size_t kMost = 8;
    if (!sender.known()) return std::nullopt;
    const auto before = std::exchange(last_, sender);
    const auto heard = heard_.find(sender);
    const bool is_by_turns = before && *before != sender && heard != heard_.end() && now - heard->second < kByTurns;
    if (heard == heard_.end() && heard_.size() >= kMost) heard_.clear();
    heard_[sender] = now;
    if (!is_by_turns) return std::nullopt;
    return std::pair<Sender, Sender>(std::minmax(*before, sender));
  }

 private:
  std::optional<Sender> last_;
  std::map<Sender, Time> heard_;  ///< when each was heard last
};

}  // namespace crsm
