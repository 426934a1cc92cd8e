#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/graph/loop_closer.hpp"

namespace crsm {

/// A loop closer beside ours, as plain as one can be: it takes the nearest keyframe of long ago, by the graph, matches
/// the newest scan to what was seen around it, and believes a good fit. It shows what it takes to put another loop
/// closer in the place of ours.
class NearbyLoopCloser : public LoopCloser {
 public:
  /// Searches always: it does not tell what it finds before it believes it.
  std::optional<GraphUpdate> Add(Keyframe keyframe, const std::optional<EarlierSearch>& earlier) override;
  const KeyframeGraph& graph() const override { return graph_; }

 private:
  std::optional<Loop> FindLoop() const;
  std::optional<KeyframeId> FindNearest() const;
  Eigen::Matrix2Xd HitsAround(KeyframeId middle) const;

  KeyframeGraph graph_;
  double next_search_m_ = 0.0;             ///< along the newest trajectory
  std::optional<KeyframeId> last_update_;  ///< by its keyframe
};

}  // namespace crsm
