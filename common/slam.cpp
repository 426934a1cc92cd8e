#include "common/slam.hpp"

namespace crsm {

Slam::Slam(const Parameters& parameters)
    : parameters_(parameters), matcher_(parameters.match), updater_(parameters.scan, parameters.update) {}

ScanMatch Slam::Process(const LaserScan& scan, const std::optional<Pose2>& T_odom_robot) {
  const ValidRays rays = FindValidRays(scan, parameters_.scan);
  const RaySelection selection = SelectRays(rays, parameters_.selection, density_scale_);
  density_scale_ = NextDensityScale(density_scale_, selection.critical.size(), parameters_.selection);

  const ScanMatch match = matcher_.Match(scan.utime, rays, selection.critical, history_, updater_.geometry(),
                                         updater_.version(), T_odom_robot);
  Restore(&scan, match);
  return match;
}

void Slam::Restore(const LaserScan* scan, const ScanMatch& match) {
  const MapDelta delta = scan ? updater_.Update(*scan, match) : updater_.UpdateWithoutScan();
  matcher_.ApplyChanges(delta.tiles);
  history_.push_back(match);
}

void Slam::Freeze() {
  updater_.Freeze();
  history_.clear();
}

}  // namespace crsm
