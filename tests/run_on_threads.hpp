#pragma once

#include <fmt/core.h>

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace crsm {

/// Does the tasks 0 to num_tasks - 1 in their order, num_threads at a time. The first that throws ends it all once
/// those under way are done: throws std::runtime_error with the task's name and what it threw.
template <class Task, class Name>
void RunOnThreads(std::size_t num_tasks, int num_threads, const Task& run_task, const Name& name_of) {
  std::string failure;
  std::mutex mutex;
  std::atomic<std::size_t> next = 0;
  const auto Work = [&] {
    for (std::size_t i = next++; i < num_tasks; i = next++) {
      try {
        run_task(i);
      } catch (const std::exception& error) {
        const std::lock_guard lock(mutex);
        failure = fmt::format("{}: {}", name_of(i), error.what());
        next = num_tasks;
      }
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < num_threads; ++i) threads.emplace_back(Work);
  for (std::thread& thread : threads) thread.join();
  if (!failure.empty()) throw std::runtime_error(failure);
}

}  // namespace crsm
