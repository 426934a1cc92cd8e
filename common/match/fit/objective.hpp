#pragma once

#include <Eigen/Core>

#include "common/match/fit/fitness_derivatives.hpp"
#include "common/match/fit/scored_map.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// The way from one place to another [m], map frame.
inline Eigen::Vector2d WayFrom(const Pose2& from, const Pose2& to) { return {to.x_m - from.x_m, to.y_m - from.y_m}; }

/// What is climbed: the fitness of some rays, less the prior: the distance from where the laser is guessed. Where the
/// walls do not tell, as along a corridor, the initial guess does.
struct Objective {
  const ScoredMap& map;
  const RaysInCells& rays;
  Pose2 initial_guess;
  double prior_per_m2;
  Eigen::Vector2d degenerate_axis{1.0, 0.0};  ///< unit vector, map frame
  double degenerate_per_m2 = 0.0;             ///< of the prior along it, besides

  double operator()(const Pose2& pose) const { return map.Fitness(rays, pose) - Prior(pose); }

  /// The same by a spline between cells, with its derivatives.
  FitnessDerivatives Differentiate(const Pose2& pose) const {
    FitnessDerivatives fitness = map.Differentiate(rays, pose);
    const Eigen::Vector2d way_m = WayFrom(initial_guess, pose);
    const double along_m = way_m.dot(degenerate_axis);
    fitness.value -= Prior(pose);
    fitness.gradient.head<2>() -= 2.0 * (prior_per_m2 * way_m + degenerate_per_m2 * along_m * degenerate_axis);
    fitness.hessian.topLeftCorner<2, 2>() -= 2.0 * (prior_per_m2 * Eigen::Matrix2d::Identity() +
                                                    degenerate_per_m2 * degenerate_axis * degenerate_axis.transpose());
    return fitness;
  }

  /// What is taken off the fitness.
  double Prior(const Pose2& pose) const {
    const Eigen::Vector2d way_m = WayFrom(initial_guess, pose);
    const double along_m = way_m.dot(degenerate_axis);
    return prior_per_m2 * way_m.squaredNorm() + degenerate_per_m2 * along_m * along_m;
  }
};

}  // namespace crsm
