#include "common/graph/background_loop_closer.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

namespace crsm {

/// Whether the condition holds now.
template <class Condition>
bool BackgroundLoopCloser::Wait(std::unique_lock<std::mutex>& lock, const GiveUp& give_up, Condition condition) {
  constexpr auto kAskEvery = std::chrono::milliseconds(100);
  if (!give_up) {
    changed_.wait(lock, condition);
    return true;
  }
  while (!changed_.wait_for(lock, kAskEvery, condition)) {
    if (give_up()) return false;
  }
  return true;
}

bool BackgroundLoopCloser::Add(Keyframe keyframe, const std::optional<EarlierSearch>& earlier, const GiveUp& give_up) {
  constexpr std::size_t kMostWaiting = 100;
  if (!thread_.joinable()) thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  std::unique_lock lock(mutex_);
  if (!Wait(lock, give_up, [&] { return waiting_.size() < kMostWaiting || error_; })) return false;
  waiting_.push_back({std::move(keyframe), earlier});
  ++num_added_;
  changed_.notify_all();
  return true;
}

int BackgroundLoopCloser::Await(int num_left, const GiveUp& give_up) {
  std::unique_lock lock(mutex_);
  Wait(lock, give_up, [&] { return num_added_ - num_searched_ <= num_left || error_; });
  return std::max(num_left, num_added_ - num_searched_);
}

std::vector<GraphUpdate> BackgroundLoopCloser::Take(int num_left) {
  Await(num_left);
  const std::lock_guard lock(mutex_);
  const int num_wanted = num_added_ - num_left;
  if (error_) std::rethrow_exception(error_);
  std::vector<GraphUpdate> taken;
  for (; !found_.empty() && found_.front().keyframe < num_wanted; found_.pop_front()) {
    taken.push_back(std::move(found_.front().update));
  }
  return taken;
}

void BackgroundLoopCloser::Run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !waiting_.empty(); }) && !stop.stop_requested()) {
    Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    std::optional<GraphUpdate> update;
    std::exception_ptr error;
    try {
      update = closer_->Add(std::move(next.keyframe), next.earlier);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    if (update) found_.push_back({num_searched_, std::move(*update)});
    ++num_searched_;
    changed_.notify_all();
    if ((error_ = error)) return;
  }
}

}  // namespace crsm
