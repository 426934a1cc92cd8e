#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <utility>

#include "services/base/status.hpp"

namespace crsm {

/// Scans that wait for a stage. A stage that falls behind drops the oldest, so that its answers stay fresh, and counts
/// each as dropped_overload. A scan that is sent again while it waits is the same scan. All that come are counted as
/// received: what was sent and is not among them was lost on the way.
///
/// At first it holds more: a matcher's second scan waits until the map's owner believes in the sender of the first
/// match (SoleSender), which takes half a second. It is as short as ever after twenty scans.
template <class Item>
class ScanQueue {
 public:
  explicit ScanQueue(Counters& counters) : counters_(counters) {}

  void Push(Item item) {
    counters_.Add("received");
    for (const Item& waiting : items_) {
      if (waiting.utime == item.utime) return counters_.Add("resent");
    }
    while (items_.size() >= capacity_) {
      items_.pop_front();
      counters_.Add("dropped_overload");
    }
    items_.push_back(std::move(item));
  }

  bool empty() const { return items_.empty(); }
  const Item& front() const { return items_.front(); }
  void Pop() {
    items_.pop_front();
    capacity_ = std::max(kCapacity, capacity_ - 1);
  }

 private:
  static constexpr std::size_t kCapacity = 20;         // half a second of a 40 Hz laser
  static constexpr std::size_t kCapacityAtFirst = 40;  // a second

  Counters& counters_;
  std::size_t capacity_ = kCapacityAtFirst;
  std::deque<Item> items_;
};

}  // namespace crsm
