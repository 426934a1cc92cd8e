#include "services/run_stack/signals.hpp"

#include <array>

#include "common/logs/stop_request.hpp"

namespace crsm {
namespace {

constexpr std::array kAwaited{SIGINT, SIGTERM, SIGHUP, SIGCHLD};

void SetDefaults() {
  for (const int number : kAwaited) signal(number, SIG_DFL);
}

}  // namespace

Signals::Signals() {
  sigemptyset(&awaited_);
  for (const int number : kAwaited) sigaddset(&awaited_, number);
  sigprocmask(SIG_BLOCK, &awaited_, nullptr);
  SetDefaults();
  if (StopRequested()) {
    CountInterrupt();
    is_terminated_ = true;  // it may have been
  }
}

void Signals::Wait(std::chrono::milliseconds longest) {
  constexpr long kNanosecondsPerMillisecond = 1'000'000;
  const timespec first{longest.count() / 1000, longest.count() % 1000 * kNanosecondsPerMillisecond};
  const timespec none{};
  for (int number = sigtimedwait(&awaited_, nullptr, &first); number > 0;
       number = sigtimedwait(&awaited_, nullptr, &none)) {
    if (number == SIGCHLD) continue;
    CountInterrupt();
    if (number != SIGINT) is_terminated_ = true;
  }
}

void Signals::CountInterrupt() {
  constexpr auto kOnce = std::chrono::milliseconds(200);
  const auto now = std::chrono::steady_clock::now();
  if (num_interrupts_ == 0 || now - last_interrupt_ > kOnce) ++num_interrupts_;
  last_interrupt_ = now;
}

void Signals::Restore() {
  SetDefaults();
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

}  // namespace crsm
