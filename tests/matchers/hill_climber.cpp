#include "tests/matchers/hill_climber.hpp"

#include <algorithm>

#include "common/match/fit/optimum.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/scan/hits.hpp"

namespace crsm {

ScanMatch HillClimber::Match(const CriticalRays& scan, const TrackingState& tracking,
                             const std::optional<Pose2>&) const {
  ScanMatch match;
  match.utime = scan.utime;
  match.num_critical = static_cast<std::int32_t>(scan.critical.size());
  if (map_.cells().empty()) return match;

  const auto recent = tracking.recent();
  const Pose2& last = recent.back().T_map_laser;
  const Pose2 motion = recent.size() < 2 ? Pose2{} : Inverse(recent[recent.size() - 2].T_map_laser) * last;
  match.T_map_laser = last * motion;
  match.state = MatchState::kLost;
  if (scan.critical.empty()) return match;

  const Eigen::Matrix2Xd hits_m = ComputeHits(scan.rays);
  const RaysInCells rays = ToCells(hits_m(Eigen::all, scan.critical), map_.geometry());
  constexpr double kFirstStep_m = 0.1;
  constexpr double kFirstStep_rad = 0.05;
  constexpr int kHalvings = 6;  // down to 2 mm
  const ScoredPose top =
      ClimbToOptimum(match.T_map_laser, kFirstStep_m, kFirstStep_rad, kHalvings, [&](const Pose2& pose) {
        ++match.evaluations;
        return map_.Fitness(rays, pose);
      });
  match.T_map_laser = {top.pose.x_m, top.pose.y_m, WrapAngle(top.pose.yaw_rad)};
  match.fitness = std::clamp(top.fitness, 0.0, 1.0);
  match.state = MatchState::kOk;
  return match;
}

}  // namespace crsm
