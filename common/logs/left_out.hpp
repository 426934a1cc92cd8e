#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace crsm {

/// The counter of scans that a process was too slow for.
inline constexpr const char* kDroppedOverload = "dropped_overload";

/// The counter of scans that were in the map when its owner was started.
inline constexpr const char* kScansBefore = "scans_before";

/// Whether so many scans are left out that a user is told: ten, or one in a hundred of all. Fewer are an accident.
inline bool IsWorthSaying(std::int64_t num_left_out, std::int64_t num_all) {
  constexpr std::int64_t kMany = 10;
  return num_left_out >= kMany || (num_left_out > 0 && 100 * num_left_out >= num_all);
}

/// Counts by name, as LaserSource::Counts and SERVICE_STATUS have them: 0 for a name that is not there.
inline std::int64_t FindCount(const std::map<std::string, std::int64_t>& counts, const std::string& name) {
  const auto found = counts.find(name);
  return found == counts.end() ? 0 : found->second;
}

/// How many scans a source has left out, by its counts.
inline std::int64_t CountLeftOut(const std::map<std::string, std::int64_t>& counts) {
  return FindCount(counts, "bad_message") + FindCount(counts, "bad_line") + FindCount(counts, "utime_repeated");
}

}  // namespace crsm
