#include "common/slam.hpp"

#include "common/match/rrhc_matcher.hpp"

namespace crsm {

Slam::Slam(const Parameters& parameters)
    : Slam(parameters,
           [&](double cell_size_m) { return std::make_unique<RrhcMatcher>(parameters.match, cell_size_m); }) {}

Slam::Slam(const Parameters& parameters, const MakeMatcher& make_matcher)
    : selector_(parameters), matcher_(make_matcher(parameters.update.cell_size_m)), updater_(parameters.update) {}

Slam::Step Slam::Process(const LaserScan& scan, const std::optional<Pose2>& T_odom_robot) {
  Step step;
  step.scan = selector_.Select(scan);
  step.match = matcher_->Match(step.scan, tracking_, T_odom_robot);
  step.match.map_version = updater_.version();
  step.drawn = Integrate(&step.scan, step.match);
  return step;
}

bool Slam::Integrate(const CriticalRays* scan, const ScanMatch& match) {
  const MapDelta delta = scan ? updater_.Update(*scan, match) : updater_.UpdateWithoutScan();
  matcher_->Apply(delta.tiles);
  tracking_.Add(match);
  return delta.drawn;
}

void Slam::FinishMap() {
  updater_.Finish();
  tracking_ = TrackingState::OnFinishedMap();
}

}  // namespace crsm
