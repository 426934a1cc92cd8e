#include "services/diagnosis/lost_news.hpp"

#include <fmt/core.h>

#include <utility>

#include "common/math/format_number.hpp"

namespace crsm {
namespace {

/// "3 lost scans", "1 scan without rays", "3 lost scans and 4 without rays".
std::string Describe(const ScanCounts& counts) {
  if (counts.lost == 0) return FormatCount(counts.without_rays, "scan") + " without rays";
  const std::string lost = FormatCount(counts.lost, "lost scan");
  return counts.without_rays == 0 ? lost : fmt::format("{} and {} without rays", lost, counts.without_rays);
}

}  // namespace

std::optional<std::string> LostNews::Add(const ScanMatch& match, LineLimit::Clock::time_point now) {
  const ScanOutcome outcome = OutcomeOf(match);
  if (outcome == ScanOutcome::kLost || outcome == ScanOutcome::kWithoutRays) {
    if (counts_.scans() == 0) first_utime_ = match.utime;
    counts_.Add(match);
    if (counts_.scans() < next_) return std::nullopt;
    next_ *= 2;
    return limit_.Pass(fmt::format("{}{} since t = {:.3f} s, which are not in the map", kLostSince, Describe(counts_),
                                   1e-6 * static_cast<double>(first_utime_)),
                       now);
  }
  next_ = kEnough;
  const ScanCounts counts = std::exchange(counts_, {});
  if (counts.scans() < kEnough) return std::nullopt;
  return limit_.Pass(fmt::format("{} after {}", kFoundAgain, Describe(counts)), now);
}

}  // namespace crsm
