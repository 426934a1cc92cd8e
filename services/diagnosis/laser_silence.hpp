#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace crsm {

/// What laser_publisher says in its status when no more scans will come.
inline constexpr const char* kPublisherFinished = "finished";

/// Judges whether a laser that is not heard is missing: at the start, and once each time that it falls silent. Knows no
/// clock of its own. A publisher of ours that is alive, and waits for a map or for the pace of a log, is no laser that
/// has failed; neither is one that said that its log is at its end.
class LaserSilence {
 public:
  using Time = std::chrono::steady_clock::time_point;
  enum class Verdict { kNone, kNothingYet, kFellSilent };

  static constexpr auto kFirstPatience = std::chrono::milliseconds(1500);
  static constexpr auto kPatience = std::chrono::seconds(3);

  explicit LaserSilence(Time start) : start_(start) {}

  /// Something came on the laser's channel.
  void Hear(Time now) {
    last_heard_ = now;
    finished_ = false;
    said_silent_ = false;
  }
  /// The status of a laser_publisher came.
  void HearPublisher(Time now, const std::string& state) {
    publisher_heard_ = now;
    finished_ = state == kPublisherFinished;
  }

  bool ever_heard() const { return last_heard_.has_value(); }

  /// Anything but kNone once for each silence.
  Verdict Look(Time now) {
    if (finished_ || (publisher_heard_ && now - *publisher_heard_ < kPatience)) return Verdict::kNone;
    if (!last_heard_) {
      if (said_nothing_ || now - start_ < kFirstPatience) return Verdict::kNone;
      said_nothing_ = true;
      return Verdict::kNothingYet;
    }
    if (said_silent_ || now - *last_heard_ < kPatience) return Verdict::kNone;
    said_silent_ = true;
    return Verdict::kFellSilent;
  }

 private:
  Time start_;
  std::optional<Time> last_heard_;
  std::optional<Time> publisher_heard_;
  bool finished_ = false;
  bool said_nothing_ = false;
  bool said_silent_ = false;
};

}  // namespace crsm
