#include "common/graph/whole_map.hpp"

#include <algorithm>

namespace crsm {

bool WholeMap::Draw(const KeyframeGraph& graph, std::span<const Pose2> poses, std::int64_t version, int most,
                    const std::function<bool(int)>& is_on_map) {
  if (num_drawn_ == 0) map_ = MapUpdater(drawing_);
  map_.SkipTo(version);
  const int until = std::min(graph.size(), num_drawn_ + most);
  for (; num_drawn_ < until; ++num_drawn_) {
    if (!is_on_map(num_drawn_)) continue;
    map_.DrawMore({&graph.keyframe(num_drawn_).rays, poses[static_cast<std::size_t>(num_drawn_)]});
  }
  return num_drawn_ == graph.size();
}

}  // namespace crsm
