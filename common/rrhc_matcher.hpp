#pragma once

#include <span>

#include "common/fitness_field.hpp"
#include "common/map_delta.hpp"
#include "common/parameters.hpp"
#include "common/ray_selection.hpp"
#include "common/scan_match.hpp"
#include "common/valid_rays.hpp"

namespace crsm {

/// Where to look for a scan before it is matched: the last pose, or the last motion repeated (section 5.3,
/// "the presumed new robot transformation, based on the speed or the kinematic model").
///
/// history: the matches so far, oldest first; at least one. No time difference is trusted unchecked: where the ratio of
/// the last two is not believable, the motion is repeated as it was.
Pose2 PredictPose(std::span<const ScanMatch> history, std::int64_t utime, const MatchParameters& parameters);

/// Finds the pose of a scan on the map by random restart hill climbing. Source: section 5.
class RrhcMatcher {
 public:
  explicit RrhcMatcher(const MatchParameters& parameters);

  /// Takes over what changed in the map. False if a change is malformed; the others are applied.
  bool ApplyChanges(std::span<const TileChange> changes);

  /// Matches a scan to the map as it is now. The result depends on the arguments, the map and the seed only.
  ///
  /// history: all matches so far, oldest first; when it is empty the scan becomes the origin of the map frame.
  /// Without rays the scan is lost.
  ScanMatch Match(std::int64_t utime, const ValidRays& rays, std::span<const int> critical,
                  std::span<const ScanMatch> history, const MapGeometry& geometry, std::int64_t map_version) const;

  const ByteMap& map() const { return map_; }

 private:
  MatchParameters parameters_;
  ByteMap map_;
  FitnessField field_;
};

}  // namespace crsm
