#pragma once

#include <optional>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/match/search/place_search.hpp"

namespace crsm {

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
