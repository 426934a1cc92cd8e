#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "common/map/byte_map.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// What finds the pose of a scan on the map so far. Holds a copy of the map, and of the scans before nothing: what is
/// to be known of them is in the tracking state.
class Matcher {
 public:
  virtual ~Matcher() = default;

  /// Takes over what changed in the map. False if a change is malformed; the others are applied.
  virtual bool Apply(std::span<const TileChange> changes) = 0;

  /// Matches a scan to the map as it is now. The same arguments on the same map give the same match, on every machine.
  ///
  /// T_odom_robot: odometry of the scan, if there is some. The match has the scan's utime; its `map_version` is left to
  /// who knows it.
  virtual ScanMatch Match(const CriticalRays& scan, const TrackingState& tracking,
                          const std::optional<Pose2>& T_odom_robot) const = 0;

  /// The same by a short look near the guess alone, where many questions are asked and most are wrong; for a matcher
  /// that has none, the same.
  virtual ScanMatch MatchNear(const CriticalRays& scan, const TrackingState& tracking,
                              const std::optional<Pose2>& T_odom_robot) const {
    return Match(scan, tracking, T_odom_robot);
  }

  /// Where on the whole map a scan was taken, by this scan alone; nothing where no place is convincing, or this matcher
  /// does not search so.
  virtual std::optional<Pose2> Locate(const CriticalRays& /*scan*/) const { return std::nullopt; }

  virtual const ByteMap& map() const = 0;
};

/// Makes a matcher for a new map with cells of that size.
using MakeMatcher = std::function<std::unique_ptr<Matcher>(double cell_size_m)>;

}  // namespace crsm
