#pragma once

#include <optional>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_graph.hpp"

namespace crsm {

/// Watches the newest trajectory after it was joined with others: a wrong join shows where the robot sees walls in what
/// the others saw to be free.
class JoinCheck {
 public:
  explicit JoinCheck(const GraphConstants& constants) : constants_(constants) {}

  /// The newest trajectory has been joined with another component.
  void Watch(const KeyframeGraph& graph);

  /// For each keyframe. Whether what was seen contradicts the join, in two places that share nothing of what was seen.
  bool IsContradicted(const KeyframeGraph& graph);

 private:
  GraphConstants constants_;
  int trajectory_ = -1;  ///< that is watched; -1: none
  double joined_m_ = 0.0;
  double next_m_ = 0.0;
  std::optional<double> contradicted_m_;  ///< where it was contradicted first
};

/// Of what was seen on the last metres and lies on what another trajectory saw within a few metres from here: the share
/// where nothing stood. Nothing if that is too little to tell.
std::optional<double> ComputeContradictionByOthers(const KeyframeGraph& graph, const GraphConstants& constants);

}  // namespace crsm
