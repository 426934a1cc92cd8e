#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "common/graph/loop_closer.hpp"

namespace crsm {

/// A LoopCloser on a thread of its own: loops are searched while the next scans are matched. How fast it is changes
/// nothing in what it gives, and when.
class BackgroundLoopCloser {
 public:
  explicit BackgroundLoopCloser(std::unique_ptr<LoopCloser> closer) : closer_(std::move(closer)) {}

  /// Asked now and then by who waits: whether to wait no longer.
  using GiveUp = std::function<bool()>;

  /// The next keyframe. Waits while very many others wait. False, and nothing done, if `give_up` says so meanwhile.
  bool Add(Keyframe keyframe, const std::optional<EarlierSearch>& earlier, const GiveUp& give_up = {});

  /// Waits until all keyframes but the newest `num_left` ones were searched. How many are left: more where `give_up`
  /// says so meanwhile.
  int Await(int num_left, const GiveUp& give_up = {});

  /// The updates, not taken before, of all keyframes but the newest `num_left` ones. Waits until those were searched.
  /// Throws what the search has thrown.
  std::vector<GraphUpdate> Take(int num_left);

 private:
  struct Waiting {
    Keyframe keyframe;
    std::optional<EarlierSearch> earlier;
  };
  struct Found {
    int keyframe;  ///< of all that were added, from 0
    GraphUpdate update;
  };

  void Run(const std::stop_token& stop);
  template <class Condition>
  bool Wait(std::unique_lock<std::mutex>& lock, const GiveUp& give_up, Condition condition);

  std::unique_ptr<LoopCloser> closer_;  ///< of the thread alone
  std::mutex mutex_;                    ///< of what follows, but for the thread itself
  std::condition_variable_any changed_;
  std::deque<Waiting> waiting_;
  int num_added_ = 0;
  int num_searched_ = 0;
  std::deque<Found> found_;
  std::exception_ptr error_;
  std::jthread thread_;  ///< from the first keyframe on; the last member, so that it ends before the others
};

}  // namespace crsm
