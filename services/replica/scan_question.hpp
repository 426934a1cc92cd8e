#pragma once

#include <cstdint>
#include <optional>

#include "services/wire/conversions.hpp"

namespace crsm {

/// Asks the map's owner whether a scan is in the map already. It is asked once where a clock steps back: its answer
/// says also up to where in time the scans behind that one are new.
class ScanQuestion {
 public:
  /// What the owner said of a scan.
  struct Answer {
    std::int64_t utime = 0;
    std::optional<ScanMatch> match;  ///< nothing: it is not in the map
  };

  /// Once answered, AnswerAbout has it until something else is asked, or it is forgotten.
  void Ask(std::int64_t utime) {
    if (asked_ == utime || AnswerAbout(utime)) return;
    asked_ = utime;
    answer_.reset();
  }
  /// The scan that waits for an answer.
  std::optional<std::int64_t> asked() const { return asked_; }

  void Handle(const scan_answer_t& answer) {
    if (answer.utime != asked_) return;
    asked_.reset();
    answer_ = Answer{answer.utime, std::nullopt};
    if (!answer.matches.empty()) answer_->match = FromMessage(answer.matches.front());
    new_after_ = answer.utime;
    new_before_ = answer.next_utime;
  }

  /// Whether a scan is known to be in no map, by what was answered about an earlier one.
  bool IsKnownToBeNew(std::int64_t utime) const { return utime > new_after_ && utime < new_before_; }
  const Answer* AnswerAbout(std::int64_t utime) const {
    return answer_ && answer_->utime == utime ? &*answer_ : nullptr;
  }
  /// A scan has just been matched: what was answered about it is true no longer, and none before it is new.
  void NoteMatched(std::int64_t utime) {
    answer_.reset();
    if (IsKnownToBeNew(utime)) new_after_ = utime;
  }

 private:
  std::optional<std::int64_t> asked_;
  std::optional<Answer> answer_;
  std::int64_t new_after_ = 0;   ///< scans with utimes between ...
  std::int64_t new_before_ = 0;  ///< ... these are in no map
};

}  // namespace crsm
