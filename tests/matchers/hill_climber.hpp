#pragma once

#include <optional>
#include <span>

#include "common/match/fit/scored_map.hpp"
#include "common/match/matcher.hpp"

namespace crsm {

/// A matcher beside ours, as plain as one can be: it climbs from where the last motion repeated leads, with the
/// critical rays, and believes what it finds. It shows what it takes to put another matcher in the place of
/// rrhc_matcher.
class HillClimber : public Matcher {
 public:
  explicit HillClimber(double cell_size_m) : map_(cell_size_m) {}

  bool Apply(std::span<const TileChange> changes) override { return map_.Apply(changes); }
  ScanMatch Match(const CriticalRays& scan, const TrackingState& tracking,
                  const std::optional<Pose2>& T_odom_robot) const override;
  const ByteMap& map() const override { return map_.cells(); }

 private:
  ScoredMap map_;
};

}  // namespace crsm
