#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "common/match/match_constants.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// A pose and how well the rays fit there.
struct ScoredPose {
  Pose2 pose;
  double fitness = 0.0;
};

/// Climbs from a pose to the nearest optimum of its fitness, by steps along each axis that halve when none leads up.
///
/// step_m, step_rad: the first steps along x and y, and of the yaw. num_halvings: after so many the climb ends.
/// fitness: of a pose; finite, or the climb has no end.
template <class Fitness>
ScoredPose ClimbToOptimum(const Pose2& from, double step_m, double step_rad, int num_halvings, Fitness&& fitness) {
  ScoredPose best{from, fitness(from)};
  for (int halving = 0; halving < num_halvings;) {
    bool climbed = false;
    for (const Pose2& step : {Pose2{step_m, 0, 0}, Pose2{0, step_m, 0}, Pose2{0, 0, step_rad}}) {
      for (const double sign : {1.0, -1.0}) {
        const Pose2& at = best.pose;
        const Pose2 next{at.x_m + sign * step.x_m, at.y_m + sign * step.y_m, at.yaw_rad + sign * step.yaw_rad};
        const double there = fitness(next);
        if (there <= best.fitness) continue;
        best = {next, there};
        climbed = true;
        break;
      }
    }
    if (climbed) continue;
    step_m *= 0.5;
    step_rad *= 0.5;
    ++halving;
  }
  return best;
}

/// The best of the poses along an axis, `reach_m` to either side in steps of `step_m`, if it is better by more than
/// `least_gain`; otherwise the pose itself.
///
/// axis: a unit vector in the frame in which the pose is given.
template <class Fitness>
Pose2 LookAlong(const Pose2& from, const Eigen::Vector2d& axis, double reach_m, double step_m, double least_gain,
                Fitness&& fitness) {
  ScoredPose best{from, fitness(from) + least_gain};
  const int num_steps = static_cast<int>(reach_m / step_m);
  for (int i = -num_steps; i <= num_steps; ++i) {
    const Pose2 pose{from.x_m + i * step_m * axis.x(), from.y_m + i * step_m * axis.y(), from.yaw_rad};
    const double there = fitness(pose);
    if (there > best.fitness) best = {pose, there};
  }
  return best.pose;
}

/// Puts the yaw into the middle of its optimum: which point of a rough optimum is its highest is chance, and on the way
/// through a building the errors of yaw are those that add up. Four widths from `width_rad` down to an eighth of it say
/// where the middle is, each from the fitness so far to either side. The narrow ones know it better, unless it is flat
/// there; so each counts by how steeply the fitness falls.
template <class Fitness>
Pose2 CentreYaw(const ScoredPose& top, double width_rad, Fitness&& fitness,
                const MatchConstants::Optimum& constants = {}) {
  const auto Turned = [&](double turn_rad) { return Pose2{top.pose.x_m, top.pose.y_m, top.pose.yaw_rad + turn_rad}; };
  double sum = 0.0;
  double sum_of_turns = 0.0;
  for (int i = 0; i < constants.widths; ++i, width_rad *= 0.5) {
    const double left = fitness(Turned(width_rad));
    const double right = fitness(Turned(-width_rad));
    const double fall = 2.0 * top.fitness - left - right;
    if (fall < constants.least_fall) continue;
    const double turn_rad = std::clamp(0.5 * (left - right) / fall, -1.0, 1.0) * width_rad;
    const double steepness = fall / width_rad;
    sum += steepness;
    sum_of_turns += steepness * turn_rad;
  }
  return sum > 0.0 ? Turned(sum_of_turns / sum) : top.pose;
}

/// The optimum next to a pose, to a fraction of a cell: to half a cell by one fitness, on from there by another, which
/// may cost more and be right between cells.
template <class Fitness, class FineFitness>
Pose2 FindOptimum(const Pose2& from, double cell_size_m, double width_rad, Fitness&& fitness, FineFitness&& fine,
                  const MatchConstants::Optimum& constants = {}) {
  const double step_rad = constants.first_step_rad;
  const int coarse = constants.coarse_halvings;
  const double left = 1.0 / (1 << coarse);  // of the first step
  const ScoredPose near = ClimbToOptimum(from, cell_size_m, step_rad, coarse, fitness);
  const ScoredPose top =
      ClimbToOptimum(near.pose, left * cell_size_m, left * step_rad, constants.halvings - coarse, fine);
  return width_rad > 0.0 ? CentreYaw(top, width_rad, fine, constants) : top.pose;
}

}  // namespace crsm
