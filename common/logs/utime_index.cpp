#include "common/logs/utime_index.hpp"

#include <algorithm>
#include <array>

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
  std::array<std::int64_t, kBlock> utimes;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (utime < blocks_[i].least || utime > blocks_[i].largest) continue;
    const std::int64_t first = static_cast<std::int64_t>(i) * kBlock;
    const auto num = static_cast<std::size_t>(std::min(kBlock, size_ - first));
    file_.Read(static_cast<std::uint64_t>(first) * sizeof(std::int64_t),
               {reinterpret_cast<std::uint8_t*>(utimes.data()), num * sizeof(std::int64_t)});
    const auto end = utimes.begin() + static_cast<std::ptrdiff_t>(num);
    const auto found = std::find(utimes.begin(), end, utime);
    if (found != end) return first + (found - utimes.begin());
  }
  return std::nullopt;
}

}  // namespace crsm
