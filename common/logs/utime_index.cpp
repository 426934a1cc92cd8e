#include "common/logs/utime_index.hpp"

#include <algorithm>
#include <limits>

namespace crsm {
namespace {

constexpr std::int64_t kBlock = 1024;

}  // namespace

void UtimeIndex::Add(std::int64_t utime) {
  if (size_ % kBlock == 0) blocks_.push_back({utime, utime});
  Block& block = blocks_.back();
  block = {std::min(block.least, utime), std::max(block.largest, utime)};
  largest_ = size_ == 0 ? utime : std::max(largest_, utime);
  file_.Append({reinterpret_cast<const std::uint8_t*>(&utime), sizeof(utime)});
  ++size_;
}

std::optional<std::int64_t> UtimeIndex::Find(std::int64_t utime) const {
  if (size_ == 0 || utime > largest_) return std::nullopt;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (utime < blocks_[i].least || utime > blocks_[i].largest) continue;
    const std::vector<std::int64_t> utimes = ReadBlock(i);
    const auto found = std::ranges::find(utimes, utime);
    if (found != utimes.end()) return static_cast<std::int64_t>(i) * kBlock + (found - utimes.begin());
  }
  return std::nullopt;
}

std::int64_t UtimeIndex::FindNext(std::int64_t utime) const {
  std::int64_t next = std::numeric_limits<std::int64_t>::max();
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const auto& [least, largest] = blocks_[i];
    if (largest <= utime || least >= next) continue;
    if (least > utime) {
      next = least;
      continue;
    }
    for (const std::int64_t other : ReadBlock(i)) {
      if (other > utime) next = std::min(next, other);
    }
  }
  return next;
}

std::optional<std::int64_t> UtimeIndex::FindLast(std::int64_t utime) const {
  std::optional<std::int64_t> last;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const auto& [least, largest] = blocks_[i];
    if (least > utime || largest <= last) continue;
    if (largest <= utime) {
      last = largest;
      continue;
    }
    for (const std::int64_t other : ReadBlock(i)) {
      if (other <= utime) last = std::max(last, std::optional(other));
    }
  }
  return last;
}

std::vector<std::int64_t> UtimeIndex::ReadBlock(std::size_t number) const {
  const std::int64_t first = static_cast<std::int64_t>(number) * kBlock;
  std::vector<std::int64_t> utimes(static_cast<std::size_t>(std::min(kBlock, size_ - first)));
  file_.Read(static_cast<std::uint64_t>(first) * sizeof(std::int64_t),
             {reinterpret_cast<std::uint8_t*>(utimes.data()), utimes.size() * sizeof(std::int64_t)});
  return utimes;
}

}  // namespace crsm
