#pragma once

#include <optional>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/place_search.hpp"

namespace crsm {

/// The robot is where it was long ago, by what its laser saw on the last metres of its path.
struct LoopFinding {
  /// How it was found.
  enum class By {
    kDrift,   ///< where the poses may have drifted to
    kCheck,   ///< the graph vouches for that place, and matches were made on it already
    kNearby,  ///< in another component, near where the robot was before a break
    kAnywhere,
  };

  KeyframeId older;     ///< the middle keyframe of the submap in which it was found
  KeyframeId newer;     ///< the newest keyframe
  Pose2 T_older_newer;  ///< to within a cell
  double score = 0.0;   ///< as of Place
  By by = By::kDrift;
  bool soon = false;  ///< after a short break, nearby: the robot can be hardly anywhere else
  bool sure = false;  ///< it needs no other that agrees with it
};

/// The best place of some submaps, and how well the best other place fits.
class BestFinding {
 public:
  BestFinding(const KeyframeGraph& graph, const GraphConstants::Submaps& constants, LoopFinding::By by)
      : graph_(graph), constants_(constants), by_(by) {}

  /// What a place must have to matter: it is better, or a rival.
  double LeastScore(double least) const;

  void Add(KeyframeId middle, const Place& place);

  /// Nothing where another place fits nearly as well.
  std::optional<LoopFinding> Unrivalled() const;

 private:
  bool AreApart(const LoopFinding& a, const LoopFinding& b) const;

  const KeyframeGraph& graph_;
  const GraphConstants::Submaps& constants_;
  LoopFinding::By by_;
  std::optional<LoopFinding> best_;
  double rival_ = 0.0;
};

}  // namespace crsm
