#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>

#include "common/match/fit/fitness_derivatives.hpp"
#include "common/match/fit/scored_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

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

/// Climbs from a pose to the optimum next to it by Newton's method. Where the fitness is no hill, or a step leads down,
/// the step is turned towards the gradient and shortened (Levenberg). No step is longer than a cell, or
/// `longest_step_rad`.
///
/// differentiate: of a pose, FitnessDerivatives.
template <class Differentiate>
ScoredPose ClimbByNewton(const Pose2& from, double cell_size_m, Differentiate&& differentiate,
                         const MatchConstants::Optimum& constants = {}) {
  const Eigen::Vector3d unit(cell_size_m, cell_size_m, constants.longest_step_rad);
  Pose2 pose = from;
  FitnessDerivatives here = differentiate(pose);
  double damping = 0.0;
  for (int pass = 1; pass < constants.most_passes; ++pass) {
    const Eigen::Matrix3d bend = -(unit.asDiagonal() * here.hessian * unit.asDiagonal());
    const double steepest = std::max(bend.cwiseAbs().maxCoeff(), 1e-9);
    Eigen::LLT<Eigen::Matrix3d> hill(bend + damping * steepest * Eigen::Matrix3d::Identity());
    for (; hill.info() != Eigen::Success; hill.compute(bend + damping * steepest * Eigen::Matrix3d::Identity())) {
      damping = std::max(4.0 * damping, constants.least_damping);
    }
    Eigen::Vector3d step = hill.solve(unit.cwiseProduct(here.gradient));
    const double length = step.cwiseAbs().maxCoeff();
    if (length > 1.0) step /= length;
    const Eigen::Vector3d way = unit.cwiseProduct(step);
    const Pose2 next{pose.x_m + way.x(), pose.y_m + way.y(), pose.yaw_rad + way.z()};
    const FitnessDerivatives there = differentiate(next);
    const bool leads_up = there.value > here.value;
    if (leads_up) {
      pose = next;
      here = there;
    }
    if (length < constants.shortest_step) break;
    damping = leads_up ? 0.25 * damping : std::max(4.0 * damping, constants.least_damping);
  }
  return {pose, here.value};
}

/// The optimum next to a pose, to a fraction of a cell, with the yaw in its middle: as of ClimbByNewton and CentreYaw.
template <class Differentiate>
Pose2 FindOptimum(const Pose2& from, double cell_size_m, double width_rad, Differentiate&& differentiate,
                  const MatchConstants::Optimum& constants = {}) {
  const ScoredPose top = ClimbByNewton(from, cell_size_m, differentiate, constants);
  if (width_rad <= 0.0) return top.pose;
  return CentreYaw(
      top, width_rad, [&](const Pose2& at) { return differentiate(at).value; }, constants);
}

}  // namespace crsm
