#include "common/graph/whole_map.hpp"

namespace crsm {

bool WholeMap::Draw(const KeyframeGraph& graph, const KeyframePoses& poses, std::int64_t version, int most,
                    const std::function<bool(KeyframeId)>& is_on_map) {
  if (num_drawn_.empty()) map_ = MapUpdater(drawing_);
  map_.SkipTo(version);
  num_drawn_.resize(static_cast<std::size_t>(graph.num_trajectories()));
  bool all_drawn = true;
  for (int i = 0; i < graph.num_trajectories(); ++i) {
    int& num_drawn = num_drawn_[static_cast<std::size_t>(i)];
    for (; num_drawn < graph.size(i) && most > 0; ++num_drawn, --most) {
      const KeyframeId id{i, num_drawn};
      if (is_on_map(id)) map_.DrawMore({graph.keyframe(id).rays, At(poses, id)});
    }
    all_drawn = all_drawn && num_drawn == graph.size(i);
  }
  return all_drawn;
}

}  // namespace crsm
