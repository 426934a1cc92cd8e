#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace crsm {

/// Says what a process waits for, once, when it has waited for the same thing for long.
class StallWatch {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kLong = std::chrono::seconds(5);

  /// What is waited for: a text with one {} for the number, which tells one wait from the next of its kind.
  struct Awaited {
    const char* what = nullptr;  ///< nullptr: nothing is waited for
    std::int64_t number = 0;
    friend bool operator==(const Awaited&, const Awaited&) = default;
  };

  /// say: gets the line, for stderr.
  StallWatch(std::string program, std::function<void(const std::string&)> say)
      : program_(std::move(program)), say_(std::move(say)) {}

  /// To be called every now and then, much more often than kLong.
  void Look(const Awaited& awaited, Clock::time_point now);

 private:
  std::string program_;
  std::function<void(const std::string&)> say_;
  Awaited awaited_;
  Clock::time_point since_{};
  bool said_ = false;
};

}  // namespace crsm
