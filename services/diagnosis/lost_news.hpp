#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/scan/scan_counts.hpp"
#include "common/scan/scan_match.hpp"
#include "services/base/line_limit.hpp"

namespace crsm {

/// Counter of START_POSE that was believed, and what the line about each has, which others pass on.
inline constexpr const char* kStartTold = "start_told";
inline constexpr const char* kToldBy = "START_POSE from ";
/// How a line begins about a place that is not taken in.
inline constexpr const char* kMarkNews = "MARK ";

/// In each line of LostNews: run_stack finds them in the log of map_updater by these.
inline constexpr const char* kLostSince = "the robot is lost: ";
inline constexpr const char* kFoundAgain = "the robot is found again";

/// Says on the terminal that the robot is lost, while it is, and that it is found again.
class LostNews {
 public:
  static constexpr std::int64_t kEnough = 10;  ///< scans in a row without a pose: a second of a slow laser

  /// The next match, of a scan that came now. What is to be said, if anything: after ten scans that are lost or without
  /// rays, whenever their number has doubled, and at their end.
  std::optional<std::string> Add(const ScanMatch& match, LineLimit::Clock::time_point now);

 private:
  ScanCounts counts_;             ///< of those without a pose, in a row
  std::int64_t first_utime_ = 0;  ///< of those
  std::int64_t next_ = kEnough;   ///< how many are said next
  LineLimit limit_;
};

}  // namespace crsm
