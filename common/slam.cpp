#include "common/slam.hpp"

#include <utility>

#include "common/graph/whole_map.hpp"
#include "common/match/rrhc_matcher.hpp"

namespace crsm {

Slam::Slam(const Parameters& parameters)
    : Slam(parameters, [match = parameters.match](double cell_size_m) {
        return std::make_unique<RrhcMatcher>(match, cell_size_m);
      }) {}

Slam::Slam(const Parameters& parameters, const MakeMatcher& make_matcher)
    : loops_(parameters.loops),
      drawing_(parameters.update),
      selector_(parameters),
      matcher_(make_matcher(parameters.update.cell_size_m)),
      mapper_(parameters.update, parameters.loops),
      loop_closer_(parameters.loops, parameters.update) {}

Slam::Step Slam::Process(const LaserScan& scan, const std::optional<Pose2>& T_odom_robot) {
  Step step;
  step.scan = selector_.Select(scan);
  step.match = matcher_->Match(step.scan, tracking_, T_odom_robot);
  step.match.map_version = map_version();
  step.drawn = Integrate(&step.scan, step.match);
  step.updates = OfferFound();
  return step;
}

/// Draws a matched scan into the map, remembers the match, and looks for loops. Whether the map was drawn.
bool Slam::Integrate(const CriticalRays* scan, const ScanMatch& match) {
  const Mapper::Step step = mapper_.Integrate(scan, match);
  matcher_->Apply(step.delta.tiles);
  tracking_.Add(match);
  if (step.T_new_old) tracking_.Move(*step.T_new_old);
  if (step.keyframe) {
    if (auto update = loop_closer_.Add(*step.keyframe)) found_.push_back(std::move(*update));
  }
  return step.delta.drawn;
}

std::vector<GraphUpdate> Slam::OfferFound() {
  for (const GraphUpdate& update : found_) mapper_.Offer(update);
  return std::exchange(found_, {});
}

bool Slam::Restore(const CriticalRays* scan, const ScanMatch& match) { return Integrate(scan, match); }

bool Slam::Restore(const GraphUpdate& update) {
  std::erase_if(found_, [&](const GraphUpdate& found) { return found.keyframe <= update.keyframe; });
  return mapper_.Offer(update);
}

void Slam::FinishMap() {
  OfferFound();
  matcher_->Apply(mapper_.Finish());
  tracking_ = TrackingState::OnFinishedMap();
}

Slam::Outcome Slam::Conclude() {
  OfferFound();
  std::vector<Pose2> poses;
  for (std::int64_t i = 0; i < map_version(); ++i) poses.push_back(mapper_.BestPose(i));
  const KeyframeGraph& graph = mapper_.graph();
  WholeMap whole(drawing_);
  whole.Draw(graph, mapper_.best_poses(), map_version(), graph.size());
  ByteMap map(drawing_.cell_size_m);
  for (std::size_t i = 0; i < whole.map().num_tiles(); ++i) {
    if (const auto tile = whole.map().TileSince(i, 0)) map.Apply(*tile);
  }
  return {std::move(map), std::move(poses), mapper_.MakeBestGraph()};
}

}  // namespace crsm
