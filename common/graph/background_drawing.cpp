#include "common/graph/background_drawing.hpp"

#include <iterator>
#include <utility>

namespace crsm {

void BackgroundDrawing::Begin(std::vector<PlacedScan> scans) {
  if (!thread_.joinable()) thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  std::unique_lock lock(mutex_);
  waiting_.clear();
  changed_.wait(lock, [&] { return !drawing_; });
  map_.emplace(rules_);
  error_ = nullptr;
  waiting_.assign(std::move_iterator(scans.begin()), std::move_iterator(scans.end()));
  changed_.notify_all();
}

void BackgroundDrawing::Add(PlacedScan scan) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(scan));
  changed_.notify_all();
}

MapUpdater BackgroundDrawing::Take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return (waiting_.empty() && !drawing_) || error_; });
  if (error_) std::rethrow_exception(error_);
  MapUpdater taken = *std::move(map_);
  map_.reset();
  return taken;
}

void BackgroundDrawing::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !waiting_.empty() && !error_; }) && !stop.stop_requested()) {
    const PlacedScan scan = std::move(waiting_.front());
    waiting_.pop_front();
    drawing_ = true;
    lock.unlock();
    std::exception_ptr error;
    try {
      map_->DrawMore(scan);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    drawing_ = false;
    error_ = error;
    if (waiting_.empty() || error_) changed_.notify_all();
  }
}

}  // namespace crsm
