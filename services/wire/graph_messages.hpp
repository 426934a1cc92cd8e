#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/graph/keyframe_graph.hpp"
#include "common/graph/loop_closer.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

// Keyframes, and what loops make of them, to messages and back. Messages are checked ones (Decode).

/// What a keyframe_t says besides the keyframe.
struct KeyframeHead {
  std::int64_t epoch = 0;  ///< of the map
  KeyframeId id;
  std::optional<KeyframeId> previous = std::nullopt;
  std::optional<KeyframeId> last_update = std::nullopt;  ///< of the map's owner
  std::optional<EarlierSearch> search = std::nullopt;    ///< what the owner knows of the search at this keyframe
};

keyframe_id_t ToMessage(KeyframeId id);
KeyframeId FromMessage(const keyframe_id_t& message);
/// Where there may be none, which is -1 and -1.
keyframe_id_t ToMessage(std::optional<KeyframeId> id);
std::optional<KeyframeId> FromOptional(const keyframe_id_t& message);

keyframe_t ToMessage(const Keyframe& keyframe, const KeyframeHead& head);
Keyframe FromMessage(const keyframe_t& message);
/// What its owner knows of the search at a keyframe.
std::optional<EarlierSearch> FindSearch(const keyframe_t& message);

/// An update, in parts of 32 KB at most. utime: of its keyframe.
std::vector<pose_graph_t> MakeParts(const GraphUpdate& update, std::int64_t utime, std::int64_t epoch);

/// Loops were looked for up to a keyframe, and nothing was found since the update of `previous`.
pose_graph_t MakeUnchanged(KeyframeId keyframe, std::optional<KeyframeId> previous, std::int64_t utime,
                           std::int64_t epoch);

/// In how many parts an update of a graph of so many keyframes may come.
int MostParts(int num_keyframes);

/// Puts the parts of an update together, in whatever order they come.
class GraphUpdateParts {
 public:
  /// A message in which something is new. The update, when all of its parts are there.
  std::optional<GraphUpdate> Add(const pose_graph_t& part);
  /// Whether none wait for others.
  bool empty() const { return parts_.empty(); }

 private:
  std::map<std::int32_t, pose_graph_t> parts_;  ///< of one update, by number
};

}  // namespace crsm
