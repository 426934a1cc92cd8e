#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>

namespace crsm {

/// What laser_publisher says in its status when no more scans will come.
inline constexpr const char* kPublisherFinished = "finished";

/// Judges whether a laser that is not heard is missing: at the start, and once each time that it falls silent; and
/// tells when it is back. Knows no clock of its own. A publisher of ours that is alive, and waits for a map or for the
/// pace of a log, is no laser that has failed; neither is one that said that its log is at its end.
class LaserSilence {
 public:
  using Time = std::chrono::steady_clock::time_point;
  enum class Verdict { kNone, kNothingYet, kFellSilent };

  static constexpr auto kFirstPatience = std::chrono::milliseconds(1500);
  static constexpr auto kPatience = std::chrono::seconds(3);

  explicit LaserSilence(Time start) : start_(start) {}

  /// Something came on the laser's channel. For how long nothing had come, if Look has told that the laser is missing.
  std::optional<Time::duration> Hear(Time now) {
    const Time before = last_heard_.value_or(start_);
    last_heard_ = now;
    finished_ = false;
    return std::exchange(is_told_, false) ? std::optional(now - before) : std::nullopt;
  }
  /// The status of a laser_publisher came.
  void HearPublisher(Time now, const std::string& state) {
    publisher_heard_ = now;
    finished_ = state == kPublisherFinished;
  }

  bool ever_heard() const { return last_heard_.has_value(); }

  /// Anything but kNone once for each silence.
  Verdict Look(Time now) {
    if (is_told_ || IsExcused(now)) return Verdict::kNone;
    if (now - last_heard_.value_or(start_) < (last_heard_ ? Time::duration(kPatience) : kFirstPatience)) {
      return Verdict::kNone;
    }
    is_told_ = true;
    return last_heard_ ? Verdict::kFellSilent : Verdict::kNothingYet;
  }

  /// Whether it goes on that the laser is missing, after Look has told.
  bool IsMissing(Time now) const { return is_told_ && !IsExcused(now); }

 private:
  bool IsExcused(Time now) const { return finished_ || (publisher_heard_ && now - *publisher_heard_ < kPatience); }

  Time start_;
  std::optional<Time> last_heard_;
  std::optional<Time> publisher_heard_;
  bool finished_ = false;
  bool is_told_ = false;  ///< that it is missing
};

}  // namespace crsm
