#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "common/match/fit/scored_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/match/matcher.hpp"

namespace crsm {

/// What the text of the paper takes for granted.
struct PaperMatchConstants {
  int num_evaluations = 10000;  ///< N_HC, section 5.3
  double window_m = 0.4;        ///< re-initialisation bound: 20 cells of 0.02 m
  double window_rad = 0.25;
  double mutation_m = 0.1;  ///< mutation bound: 5 cells of 0.02 m
  double mutation_rad = 0.1;
  double unexplored_score = -100.0;  ///< section 5.2, line 7
  MatchConstants::Prediction prediction = {};
  double satisfying_fitness = 1.0;  ///< the search stops here
};

/// Finds the pose of a scan as the text of the paper does: random restart hill climbing with the critical rays, on the
/// cells as they are, from "the presumed new robot transformation, based on the speed". A scan is never said to be
/// lost, unless it has no rays, and no match has a covariance. Source: section 5.
class PaperMatcher : public Matcher {
 public:
  PaperMatcher(std::uint64_t seed, double cell_size_m, const PaperMatchConstants& constants = {})
      : seed_(seed), constants_(constants), map_(cell_size_m, {constants.unexplored_score, false}) {}

  bool Apply(std::span<const TileChange> changes) override { return map_.Apply(changes); }
  ScanMatch Match(const CriticalRays& scan, const TrackingState& tracking,
                  const std::optional<Pose2>& T_odom_robot) const override;
  const ByteMap& map() const override { return map_.cells(); }

 private:
  std::uint64_t seed_;
  PaperMatchConstants constants_;
  ScoredMap map_;
};

}  // namespace crsm
