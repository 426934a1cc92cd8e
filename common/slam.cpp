#include "common/slam.hpp"

#include <utility>

#include "common/match/rrhc_matcher.hpp"

namespace crsm {

Slam::Slam(const Parameters& parameters)
    : Slam(parameters, [match = parameters.match](double cell_size_m) {
        return std::make_unique<RrhcMatcher>(match, cell_size_m);
      }) {}

Slam::Slam(const Parameters& parameters, const MakeMatcher& make_matcher)
    : loops_(parameters.loops),
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
  return step;
}

bool Slam::Integrate(const CriticalRays* scan, const ScanMatch& match) {
  const Mapper::Step step = mapper_.Integrate(scan, match);
  matcher_->Apply(step.delta.tiles);
  tracking_.Add(match);
  if (step.keyframe) CloseLoops(*step.keyframe);
  return step.delta.drawn;
}

/// What a keyframe brings takes effect some keyframes later: so loops can be searched while the robot drives on.
void Slam::CloseLoops(const Keyframe& keyframe) {
  updates_.push_back(loop_closer_.Add(keyframe));
  const int newest = updates_.back().keyframe;
  for (; !updates_.empty() && updates_.front().keyframe <= newest - loops_.lag; updates_.pop_front()) {
    const auto correction = mapper_.Apply(updates_.front());
    if (!correction) continue;
    matcher_->Apply(correction->tiles);
    tracking_.Move(correction->T_new_old);
  }
}

void Slam::FinishMap() {
  for (const GraphUpdate& update : std::exchange(updates_, {})) {
    if (const auto correction = mapper_.Apply(update)) matcher_->Apply(correction->tiles);
  }
  matcher_->Apply(mapper_.Finish());
  tracking_ = TrackingState::OnFinishedMap();
}

Slam::Outcome Slam::Conclude() const {
  KeyframeGraph graph = mapper_.graph();
  for (const GraphUpdate& update : updates_) graph.Apply(update);
  return {mapper_.DrawWhole(graph), mapper_.CorrectedPoses(graph), std::move(graph)};
}

}  // namespace crsm
