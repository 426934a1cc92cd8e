#include "services/journal/match_store.hpp"

#include <algorithm>
#include <span>
#include <type_traits>
#include <vector>

namespace crsm {
namespace {

// The file is this process's own: a match lies in it as it lies in memory.
static_assert(std::is_trivially_copyable_v<ScanMatch>);

std::span<std::uint8_t> BytesOf(std::span<ScanMatch> matches) {
  return {reinterpret_cast<std::uint8_t*>(matches.data()), matches.size_bytes()};
}

}  // namespace

void MatchStore::Append(const ScanMatch& match) {
  ScanMatch copy = match;
  file_.Append(BytesOf({&copy, 1}));
  utimes_.Add(match.utime);
  ++size_;
}

ScanMatch MatchStore::At(std::int64_t index) const {
  ScanMatch match;
  file_.Read(static_cast<std::uint64_t>(index) * sizeof(ScanMatch), BytesOf({&match, 1}));
  return match;
}

std::optional<ScanMatch> MatchStore::Find(std::int64_t utime) const {
  const auto index = utimes_.Find(utime);
  return index ? std::optional(At(*index)) : std::nullopt;
}

std::optional<ScanAt> MatchStore::FindScan(std::optional<std::int64_t> utime) const {
  const auto index = utime ? utimes_.Find(*utime) : std::nullopt;
  return index ? std::optional(ScanAt{*index, At(*index)}) : std::nullopt;
}

std::optional<ScanAt> MatchStore::FindUpTo(std::int64_t utime) const { return FindScan(utimes_.FindLast(utime)); }

std::optional<ScanAt> MatchStore::FindBehind(std::int64_t utime) const { return FindScan(utimes_.FindNext(utime)); }

MatchSequence MatchStore::Sequence() const {
  return MatchSequence([this](const MatchSequence::Visit& visit) {
    constexpr std::int64_t kAtOnce = 256;
    std::vector<ScanMatch> matches;
    for (std::int64_t first = 0; first < size_; first += kAtOnce) {
      matches.resize(static_cast<std::size_t>(std::min(kAtOnce, size_ - first)));
      file_.Read(static_cast<std::uint64_t>(first) * sizeof(ScanMatch), BytesOf(matches));
      std::for_each(matches.begin(), matches.end(), visit);
    }
  });
}

}  // namespace crsm
