#pragma once

#include <cstdint>
#include <string>

#include "common/scan/scan_match.hpp"

namespace crsm {

/// What has become of a scan that was matched. Each scan is one of these, and this is the only place that says which.
enum class ScanOutcome : std::int8_t {
  kOnMap,        ///< it has a pose on the map that is shown
  kFloating,     ///< it has a pose, but on another piece, with a frame of its own
  kLost,         ///< it has measurements, but no pose explains them
  kWithoutRays,  ///< nothing of it was a measurement
};

/// match: with `floating` as the pose graph says by now (Mapper::BestMatch).
inline ScanOutcome OutcomeOf(const ScanMatch& match) {
  const bool is_guess = match.state == MatchState::kLost || match.state == MatchState::kFirst;
  if (is_guess && match.num_critical == 0) return ScanOutcome::kWithoutRays;
  if (match.state == MatchState::kLost) return ScanOutcome::kLost;
  return match.floating ? ScanOutcome::kFloating : ScanOutcome::kOnMap;
}

/// How many scans have become what.
struct ScanCounts {
  std::int64_t on_map = 0;
  std::int64_t floating = 0;
  std::int64_t lost = 0;
  std::int64_t without_rays = 0;

  void Add(const ScanMatch& match) { ++Of(OutcomeOf(match)); }

  std::int64_t scans() const { return on_map + floating + lost + without_rays; }

  friend bool operator==(const ScanCounts&, const ScanCounts&) = default;

 private:
  std::int64_t& Of(ScanOutcome outcome) {
    switch (outcome) {
      case ScanOutcome::kOnMap:
        return on_map;
      case ScanOutcome::kFloating:
        return floating;
      case ScanOutcome::kLost:
        return lost;
      case ScanOutcome::kWithoutRays:
        break;
    }
    return without_rays;
  }
};

/// What is not on the map, for people: "3 floating (on another piece), 2 lost, 1 without rays". Lost scans are always
/// named, the others where there are any.
std::string DescribeOthers(const ScanCounts& counts);

}  // namespace crsm
