#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "common/graph/keyframe_graph.hpp"

namespace crsm {

/// Finds where the path comes back to where it was, and moves the keyframes to where they agree best.
///
/// The same keyframes give the same updates, to the last bit, on every machine: a loop closer that is started again is
/// given all keyframes again.
class LoopCloser {
 public:
  virtual ~LoopCloser() = default;

  /// The next keyframe. Returns what it has brought to the graph; nothing if it changes nothing.
  virtual std::optional<GraphUpdate> Add(Keyframe keyframe) = 0;

  /// All keyframes so far, at their corrected poses, and the loops between them.
  virtual const KeyframeGraph& graph() const = 0;
};

/// Makes a loop closer for a new map.
using MakeLoopCloser = std::function<std::unique_ptr<LoopCloser>()>;

}  // namespace crsm
