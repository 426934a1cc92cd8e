#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/logs/gzip_file.hpp"
#include "services/wire/lcm_event.hpp"

namespace crsm {

/// The events of an LCM log, as lcm-logger writes them, plain or compressed by gzip.
///
/// lcm::LogFile believes the lengths in a log and knows no gzip. Here a damaged stretch is passed over to the next
/// whole event: an event counts as whole if another follows it, or the end of the file, or if no other begins inside
/// it.
class LcmEventLog {
 public:
  struct Event {
    std::string channel;
    std::string_view data;            ///< valid until the next call
    std::int64_t recorded_utime = 0;  ///< by the clock of who wrote the log
  };

  /// Throws std::runtime_error if the file cannot be opened.
  explicit LcmEventLog(const std::string& path) : file_(path) {}

  /// The next event in the log's order; nothing at its end. Throws std::runtime_error if the file cannot be read.
  std::optional<Event> Next();

  double Progress() const { return file_.Progress(); }

  std::int64_t num_bad_events() const { return num_bad_events_; }     ///< damaged stretches passed over
  bool truncated() const { return torn_tail_ || file_.truncated(); }  ///< the log ends within an event, or its gzip

 private:
  void SkipToSync();

  GzipFile file_;
  std::int64_t num_bad_events_ = 0;
  bool torn_tail_ = false;
};

}  // namespace crsm
