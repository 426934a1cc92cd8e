#pragma once

#include <optional>
#include <span>

#include "common/map/map_delta.hpp"
#include "common/match/fitness_field.hpp"
#include "common/parameters.hpp"
#include "common/scan/ray_selection.hpp"
#include "common/scan/scan_match.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// Finds the pose of a scan on the map by random restart hill climbing. Source: section 5.
class RrhcMatcher {
 public:
  explicit RrhcMatcher(const MatchParameters& parameters);

  /// Takes over what changed in the map. False if a change is malformed; the others are applied.
  bool ApplyChanges(std::span<const TileChange> changes);

  /// Matches a scan to the map as it is now. The result depends on the arguments, the map and the seed only.
  ///
  /// history: all matches so far, oldest first. When the map is empty the scan becomes the origin of the map frame.
  /// T_odom_robot: odometry of the scan, if there is some; of use only where the parameters say so. The match keeps it
  /// for the next one.
  ///
  /// The search is short where the first climbs lead to a fitness as good as that of the last scans, and goes on in a
  /// wider window where it stays poor. It starts from the pose that the velocity model tells, or from odometry's where
  /// that fits clearly better, or the last scan was lost or left open how far the robot went. Where the walls leave the
  /// position open along an axis, a pose along it that fits clearly better is taken instead. A scan that nothing
  /// explains, or one without rays, is lost: its pose is then a guess, the last one or by odometry.
  ///
  /// A map that was there before the first scan of the history is a finished one: where the first scan was taken is
  /// searched around the start that the parameters name, or on the whole map, and there again after ten scans were lost
  /// in a row.
  ScanMatch Match(std::int64_t utime, const ValidRays& rays, std::span<const int> critical,
                  std::span<const ScanMatch> history, const MapGeometry& geometry, std::int64_t map_version,
                  const std::optional<Pose2>& T_odom_robot = std::nullopt) const;

  const ByteMap& map() const { return map_; }

 private:
  MatchParameters parameters_;
  ByteMap map_;
  FitnessField field_;
};

}  // namespace crsm
