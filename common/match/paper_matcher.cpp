#include "common/match/paper_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "common/match/fit/optimum.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/match/guess/motion_prediction.hpp"
#include "common/match/search/mutate.hpp"
#include "common/math/columns.hpp"
#include "common/scan/hits.hpp"

namespace crsm {

ScanMatch PaperMatcher::Match(const CriticalRays& scan, const TrackingState& tracking,
                              const std::optional<Pose2>& /*T_odom_robot*/) const {
  ScanMatch match;
  match.utime = scan.utime;
  match.num_critical = static_cast<std::int32_t>(scan.critical.size());
  if (map_.cells().empty()) return match;

  const Pose2 guess = tracking.empty() ? Pose2{} : PredictPose(tracking.recent(), constants_.prediction);
  match.state = MatchState::kLost;
  match.T_map_laser = guess;
  if (scan.critical.empty()) return match;

  const RaysInCells rays = ToCells(SelectColumns(ComputeHits(scan.rays), scan.critical), map_.geometry());
  Random random(seed_, static_cast<std::uint64_t>(scan.utime));
  double highest = -HUGE_VAL;
  const auto Evaluate = [&](const Pose2& pose) {
    ++match.evaluations;
    const double fitness = map_.Fitness(rays, pose);
    if (fitness > highest) match.best_evaluation = match.evaluations;
    highest = std::max(highest, fitness);
    return ScoredPose{pose, fitness};
  };
  const auto Finished = [&](const ScoredPose& pose) {
    return match.evaluations >= constants_.num_evaluations || pose.fitness >= constants_.satisfying_fitness;
  };
  const auto Climb = [&](ScoredPose climber) {  // for as long as every child beats its parent
    while (!Finished(climber)) {
      const ScoredPose child = Evaluate(Mutate(climber.pose, {constants_.mutation_m, constants_.mutation_rad}, random));
      if (child.fitness <= climber.fitness) break;
      climber = child;
    }
    return climber;
  };
  ScoredPose best = Climb(Evaluate(guess));
  while (!Finished(best)) {
    const ScoredPose climbed = Climb(Evaluate(Mutate(guess, {constants_.window_m, constants_.window_rad}, random)));
    if (climbed.fitness > best.fitness) best = climbed;
  }
  match.state = MatchState::kOk;
  match.T_map_laser = {best.pose.x_m, best.pose.y_m, WrapAngle(best.pose.yaw_rad)};
  match.fitness = std::clamp(best.fitness, 0.0, 1.0);
  return match;
}

}  // namespace crsm
