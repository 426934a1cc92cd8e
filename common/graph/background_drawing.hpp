#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "common/map/map_updater.hpp"

namespace crsm {

/// Draws a map on a thread of its own, while scans go on to be matched to another one. How fast it is changes nothing
/// in what it draws.
class BackgroundDrawing {
 public:
  explicit BackgroundDrawing(const DrawingRules& rules) : rules_(rules) {}

  /// Begins a map with scans that are drawn in their order. What was begun before is dropped.
  void Begin(std::vector<PlacedScan> scans);

  /// Draws one more on top.
  void Add(PlacedScan scan);

  /// The map; waits until all is drawn. Throws what drawing has thrown.
  MapUpdater Take();

 private:
  void Run(const std::stop_token& stop);

  DrawingRules rules_;
  std::mutex mutex_;  ///< of what follows
  std::condition_variable_any changed_;
  std::deque<PlacedScan> waiting_;
  std::optional<MapUpdater> map_;
  bool drawing_ = false;  ///< the thread has the map, and a scan
  std::exception_ptr error_;
  std::jthread thread_;  ///< from the first map on; the last member, so that it ends before the others
};

}  // namespace crsm
