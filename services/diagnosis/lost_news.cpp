#include "services/diagnosis/lost_news.hpp"

#include <fmt/core.h>

#include <utility>

namespace crsm {

std::optional<std::string> LostNews::Add(const ScanMatch& match, LineLimit::Clock::time_point now) {
  if (match.state == MatchState::kLost) {
    if (num_lost_++ == 0) first_utime_ = match.utime;
    if (num_lost_ < next_) return std::nullopt;
    next_ *= 2;
    return limit_.Pass(fmt::format("{}{} scans since t = {:.3f} s, which are not in the map", kLostSince, num_lost_,
                                   1e-6 * static_cast<double>(first_utime_)),
                       now);
  }
  next_ = kEnough;
  const std::int64_t num_lost = std::exchange(num_lost_, 0);
  if (num_lost < kEnough) return std::nullopt;
  return limit_.Pass(fmt::format("{} after {} lost scans", kFoundAgain, num_lost), now);
}

}  // namespace crsm
