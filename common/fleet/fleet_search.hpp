#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "common/fleet/fleet_constants.hpp"
#include "common/fleet/fleet_graph.hpp"
#include "common/match/search/line_spectrum.hpp"
#include "common/match/search/place_search.hpp"

namespace crsm {

/// Looks for what a robot sees in what others have seen.
///
/// What is not one piece with it is searched as a whole, in any direction, as JoinSearch does in one map. What is one
/// piece is searched near where the robot is, as far as the poses may have drifted apart.
class FleetSearch {
 public:
  explicit FleetSearch(const FleetConstants& constants = {}) : constants_(constants) {}

  /// For the newest keyframe of a map, in pieces of other maps that it is not part of. Nothing where no place fits, or
  /// another one fits nearly as well. found_before: where it was found some metres ago.
  std::optional<FleetFinding> SearchElsewhere(const FleetGraph& fleet, int map,
                                              const std::vector<FleetKeyframeId>& found_before);

  /// For the newest keyframe of a map, in what another map saw nearest to it, within its piece. way_m: driven since it
  /// was known last how the two lie to each other.
  std::optional<FleetFinding> SearchNear(const FleetGraph& fleet, int map, double way_m) const;

  /// Of what the newest keyframe of a map saw on the last metres, and lies on what another map saw within a few metres:
  /// the share where nothing stood. Nothing if that is too little to tell.
  std::optional<double> ComputeContradiction(const FleetGraph& fleet, int map) const;

 private:
  /// Part of a trajectory: its map and number, and the how manyeth.
  using PartKey = std::tuple<int, int, int>;
  struct DrawnPart {
    KeyframeId middle;
    double length_m;  ///< of the trajectory, when it was drawn
    HitPyramid pyramid;
    LineSpectrum spectrum;
  };
  struct Turn {
    std::vector<PartKey> now;
    std::vector<PartKey> later;
  };

  std::vector<PartKey> ListParts(const FleetGraph& fleet, int map) const;
  Turn TakeTurns(const FleetGraph& fleet, int map, const std::vector<PartKey>& parts,
                 const std::vector<FleetKeyframeId>& found_before) const;
  const DrawnPart& Draw(const FleetGraph& fleet, const PartKey& key);
  std::optional<FleetKeyframeId> FindNearest(const FleetGraph& fleet, int map, double within_m) const;
  KeyframeId MiddleOf(const FleetGraph& fleet, const PartKey& key) const;

  FleetConstants constants_;
  std::map<PartKey, DrawnPart> drawn_;
  std::deque<PartKey> drawn_order_;  ///< the oldest first
};

}  // namespace crsm
