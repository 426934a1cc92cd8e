#pragma once

#include <signal.h>

#include <chrono>

namespace crsm {

/// The signals of a supervisor. They reach it only while it waits: nothing is interrupted, and none is missed.
class Signals {
 public:
  /// From now on SIGINT, SIGTERM and SIGHUP are counted and do nothing else, also where whoever started this process
  /// had them ignored, as a shell does for what runs in the background.
  /// A request that this process has caught before (StopRequested) counts.
  Signals();

  /// Waits until a signal comes, the end of a child process too, or the time is over.
  void Wait(std::chrono::milliseconds longest);

  /// How often this process was asked to end. What comes within a moment is the same request: timeout(1) sends its
  /// signal to a process and to its group.
  int num_interrupts() const { return num_interrupts_; }

  /// Whether one of them was no Ctrl-C: somebody who is not at the terminal wants an end, or the terminal is closed.
  bool is_terminated() const { return is_terminated_; }

  /// For a child process, before it becomes another program: as if this process had never touched them.
  static void Restore();

 private:
  void CountInterrupt();

  sigset_t awaited_{};
  int num_interrupts_ = 0;
  bool is_terminated_ = false;
  std::chrono::steady_clock::time_point last_interrupt_;
};

}  // namespace crsm
