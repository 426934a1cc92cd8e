#pragma once

#include "common/pose2.hpp"

namespace crsm {

/// A pose and how well the rays fit there.
struct Individual {
  Pose2 pose;
  double fitness = 0.0;
};

/// Climbs from a pose to the nearest summit of its fitness, by steps along each axis that halve when none leads up.
///
/// step_m, step_rad: the first steps along x and y, and of the yaw. num_halvings: after so many the climb ends.
/// fitness: of a pose; finite, or the climb has no end.
template <class Fitness>
Individual ClimbToSummit(const Pose2& from, double step_m, double step_rad, int num_halvings, Fitness&& fitness) {
  Individual best{from, fitness(from)};
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

}  // namespace crsm
