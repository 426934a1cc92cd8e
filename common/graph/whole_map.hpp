#pragma once

#include <functional>
#include <vector>

#include "common/graph/mapper.hpp"
#include "common/map/map_updater.hpp"

namespace crsm {

/// All that was seen, where it belongs by all that is known: for who looks at the map, not for who matches on it.
///
/// It is drawn when somebody wants to see it, some scans at a time, so that who draws it can do other things between.
class WholeMap {
 public:
  explicit WholeMap(const DrawingRules& drawing) : drawing_(drawing), map_(drawing) {}

  /// Keyframes are elsewhere than they were: the map is to be drawn anew, as a version of its own.
  void Forget() { num_drawn_.clear(); }

  /// Draws some keyframes that are not in the map yet, for the version of that number, no smaller than before. poses:
  /// T_map_keyframe. Whether all are drawn.
  bool Draw(const KeyframeGraph& graph, const KeyframePoses& poses, std::int64_t version, int most) {
    return Draw(graph, poses, version, most, [](KeyframeId) { return true; });
  }

  /// The same of a mapper's keyframes that are on its map, by all that it knows.
  bool Draw(const Mapper& mapper, int most) {
    return Draw(mapper.graph(), mapper.best_poses(), mapper.local().version(), most,
                [&](KeyframeId keyframe) { return mapper.IsKeyframeOnMap(keyframe); });
  }

  /// The same of the keyframes of one component.
  bool Draw(const Mapper& mapper, int component, std::int64_t version, int most) {
    return Draw(mapper.graph(), mapper.best_poses(), version, most,
                [&, component](KeyframeId keyframe) { return mapper.IsKeyframeOf(component, keyframe); });
  }

  const MapUpdater& map() const { return map_; }

 private:
  bool Draw(const KeyframeGraph& graph, const KeyframePoses& poses, std::int64_t version, int most,
            const std::function<bool(KeyframeId)>& is_on_map);

  DrawingRules drawing_;
  MapUpdater map_;
  std::vector<int> num_drawn_;  ///< keyframes, by trajectory; none before the first was drawn
};

}  // namespace crsm
