#pragma once

#include <cstddef>
#include <deque>
#include <utility>

#include "common/logs/left_out.hpp"
#include "services/base/status.hpp"

namespace crsm {

/// Scans that wait for a stage. A stage that falls behind drops the oldest, so that its answers stay fresh, and counts
/// each as dropped_overload. A scan that is sent again while it waits is the same scan. All that come are counted as
/// received: what was sent and is not among them was lost on the way.
template <class Item>
class ScanQueue {
 public:
  explicit ScanQueue(Counters& counters) : counters_(counters) {}

  void Push(Item item) {
    counters_.Add("received");
    for (const Item& waiting : items_) {
      if (waiting.utime == item.utime) return counters_.Add("resent");
    }
    while (items_.size() >= kCapacity) {
      items_.pop_front();
      counters_.Add(kDroppedOverload);
    }
    items_.push_back(std::move(item));
  }

  bool empty() const { return items_.empty(); }
  const Item& front() const { return items_.front(); }
  void Pop() { items_.pop_front(); }

 private:
  static constexpr std::size_t kCapacity = 20;  // half a second of a 40 Hz laser

  Counters& counters_;
  std::deque<Item> items_;
};

}  // namespace crsm
