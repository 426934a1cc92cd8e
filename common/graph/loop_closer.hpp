#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "common/graph/keyframe_graph.hpp"

namespace crsm {

/// What the search at a keyframe came to when it was done.
struct EarlierSearch {
  std::optional<LoopFinding> finding;  ///< none: nothing was found
  /// What that has brought to the graph, or the keyframe's other checks have; nullptr: nothing, or it is not told.
  std::shared_ptr<const GraphUpdate> update = nullptr;
};

/// Finds where the path comes back to where it was, and moves the keyframes to where they agree best.
///
/// The same keyframes give the same updates, to the last bit, on every machine: a loop closer that is started again is
/// given all keyframes again. Searches take long, what is made of their findings does not: so it is also given what was
/// found then.
class LoopCloser {
 public:
  virtual ~LoopCloser() = default;

  /// The next keyframe. Returns what was found and what that has brought to the graph; nothing if nothing was found.
  /// earlier: of an earlier search at this keyframe, which need not be done again; it may be left aside.
  virtual std::optional<GraphUpdate> Add(Keyframe keyframe, const std::optional<EarlierSearch>& earlier) = 0;

  /// All keyframes so far, at their corrected poses, and the loops between them.
  virtual const KeyframeGraph& graph() const = 0;
};

/// Makes a loop closer for a new map.
using MakeLoopCloser = std::function<std::unique_ptr<LoopCloser>()>;

}  // namespace crsm
