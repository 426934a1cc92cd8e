#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "common/graph/graph_constants.hpp"
#include "common/graph/keyframe_graph.hpp"
#include "common/graph/loop_finding.hpp"
#include "common/match/match_constants.hpp"
#include "common/match/search/line_spectrum.hpp"
#include "common/match/search/place_search.hpp"

namespace crsm {

/// Looks for what the robot sees in all that hangs together with it by nothing: first near where it was before a break,
/// then everywhere, in any direction.
///
/// What makes it cheap: the lines that were seen tell how the robot may be turned; a place where hits lie in what was
/// seen to be free is soon ruled out; the submaps of finished trajectories are drawn once; and of very many only a part
/// is searched at a time.
class JoinSearch {
 public:
  explicit JoinSearch(const GraphConstants& constants, const MatchConstants& match = {})
      : constants_(constants), match_(match) {}

  /// For the newest keyframe. Nothing where no place fits, or another one fits nearly as well. found_before: keyframes
  /// of other components near which it was found some metres ago.
  std::optional<LoopFinding> Search(const KeyframeGraph& graph, const std::vector<KeyframeId>& found_before);

 private:
  struct DrawnSubmap {
    HitPyramid pyramid;
    LineSpectrum spectrum;
  };

  struct Turn {
    std::vector<KeyframeId> now;
    std::vector<KeyframeId> later;
  };

  Turn TakeTurns(const KeyframeGraph& graph, const std::vector<KeyframeId>& middles,
                 const std::vector<KeyframeId>& found_before) const;
  std::optional<LoopFinding> SearchNearby(const KeyframeGraph& graph) const;
  std::vector<KeyframeId> FindMiddles(const KeyframeGraph& graph) const;
  const DrawnSubmap& Draw(const KeyframeGraph& graph, KeyframeId middle);

  GraphConstants constants_;
  MatchConstants match_;
  std::map<KeyframeId, DrawnSubmap> drawn_;  ///< by the middle
  std::deque<KeyframeId> drawn_order_;       ///< the oldest first
};

}  // namespace crsm
