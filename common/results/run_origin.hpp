#pragma once

#include <cstdint>
#include <string>

namespace crsm {

/// What a map was made of, and when. For people who find a folder of results and ask.
struct RunOrigin {
  /// The logs by their names, and the flags that the map depends on: "intel.clf.gz --preset sick".
  /// A map that was continued has several of these, each behind "; then ". Empty where nobody knows.
  std::string made_from;
  std::string mapped;  ///< when the run has ended, as of FormatUtc; empty where nobody knows
};

/// Of what a map is that goes on. Of one that was continued many times the oldest parts are left out.
std::string JoinOrigins(const std::string& earlier, const std::string& now);

/// "2003-07-31T10:20:30Z" of microseconds since 1970. Empty before 1990: that is no date, but a clock that began at 0.
std::string FormatUtc(std::int64_t utime);

}  // namespace crsm
