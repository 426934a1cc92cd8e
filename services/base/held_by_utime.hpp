#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <limits>
#include <utility>

namespace crsm {

/// Items that wait for another message of the same utime, in the order in which they came: `kMost` at most, the oldest
/// gives way. One that comes again is the same item.
template <class Item, std::size_t kMost>
class HeldByUtime {
 public:
  void Hold(Item item) {
    if (item.utime <= newest_utime_ && Find(item.utime)) return;  // newer than everything held: skip the search
    newest_utime_ = std::max(newest_utime_, item.utime);
    if (items_.size() == kMost) items_.pop_front();
    items_.push_back(std::move(item));
  }

  /// nullptr if there is none; valid until the next call of another method.
  const Item* Find(std::int64_t utime) const {
    const auto found =
        std::find_if(items_.begin(), items_.end(), [&](const Item& item) { return item.utime == utime; });
    return found == items_.end() ? nullptr : &*found;
  }

  /// Drops an item and all that came before it; nothing if it is not there.
  void DropThrough(std::int64_t utime) {
    if (!Find(utime)) return;
    while (items_.front().utime != utime) items_.pop_front();
    items_.pop_front();
  }

 private:
  std::deque<Item> items_;
  std::int64_t newest_utime_ = std::numeric_limits<std::int64_t>::min();  ///< of all that were ever held
};

}  // namespace crsm
