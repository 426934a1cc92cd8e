#pragma once

#include <cstdint>
#include <optional>

#include "services/wire/conversions.hpp"

namespace crsm {

/// Asks the map's owner whether a scan is in the map already.
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
  }
  const Answer* AnswerAbout(std::int64_t utime) const {
    return answer_ && answer_->utime == utime ? &*answer_ : nullptr;
  }
  /// What was answered is true no longer: the scan has just been matched.
  void Forget() { answer_.reset(); }

 private:
  std::optional<std::int64_t> asked_;
  std::optional<Answer> answer_;
};

}  // namespace crsm
