#pragma once

#include <atomic>
#include <stdexcept>

namespace crsm {

/// Set by a signal that asks the process to end. Never in a program of others that uses the library.
inline std::atomic<bool> stop_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free);  // or no signal handler might set it

/// Whether the process is to end: what takes long asks now and then, and what reads a file ends as if the file did.
inline bool StopRequested() { return stop_requested.load(std::memory_order_relaxed); }

/// Thrown by what was ended on request before it was done: nothing is wrong. what(): what was kept, and what was not.
struct Stopped : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace crsm
