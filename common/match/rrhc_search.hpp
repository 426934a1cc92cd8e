#pragma once

#include <cmath>
#include <functional>
#include <utility>

#include "common/match/summit.hpp"
#include "common/math/random.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// Bounds of a random change of the genome [Dx, Dy, Dtheta]. Source: section 5.1.
struct MotionBounds {
  double x_m;  ///< and y
  double yaw_rad;

  friend MotionBounds operator*(double factor, const MotionBounds& bounds) {
    return {factor * bounds.x_m, factor * bounds.yaw_rad};
  }
};

/// Random restart hill climbing: the search for the pose of one scan. Source: section 5.3.
class RrhcSearch {
 public:
  using Fitness = std::function<double(const Pose2&)>;

  /// parameters: outlive the search.
  RrhcSearch(const MatchParameters& parameters, Fitness fitness, Random random)
      : parameters_(parameters), fitness_(std::move(fitness)), random_(random) {}

  /// Climbs from the presumed pose, then again and again from random ones in a window around it.
  ///
  /// Ends when `num_evaluations` (>= 1) are spent, or when the best of the first few climbs and all later ones is good
  /// `enough`. Each random climb starts from the best of `num_draws` poses.
  Individual Run(const Pose2& presumed, const MotionBounds& window, int num_draws, int num_evaluations, double enough);

  int evaluations() const { return evaluations_; }          ///< of all runs
  int best_evaluation() const { return best_evaluation_; }  ///< the one that found the best pose so far

 private:
  Individual Draw(const Pose2& pose, const MotionBounds& bounds, int num_draws);
  Individual Climb(const Individual& start);
  Individual ClimbFixed(Individual individual);
  Individual ClimbShrinking(Individual individual);
  Individual Evaluate(const Pose2& pose);
  bool Finished(const Individual& best) const;

  const MatchParameters& parameters_;
  Fitness fitness_;
  Random random_;
  int evaluations_ = 0;
  int last_evaluation_ = 0;
  int best_evaluation_ = 0;
  double best_fitness_ = -HUGE_VAL;
};

}  // namespace crsm
