#pragma once

#include <cmath>
#include <functional>

#include "common/match/optimum.hpp"
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

/// Where to search, and when to stop.
struct SearchTask {
  Pose2 initial_guess;  ///< the first climb starts here
  MotionBounds window;  ///< the later ones somewhere in here around it ...
  int num_draws;        ///< ... each from the best of so many random poses, >= 1
  int num_evaluations;  ///< the search ends when they are spent, >= 1 ...
  double enough;        ///< ... or when the best of the first few climbs and all later ones is as good as this
};

/// What a search has found, and how.
struct SearchResult {
  ScoredPose best;
  int evaluations = 0;
  int best_evaluation = 0;  ///< the one that found the best pose, counted from 1
};

/// Random restart hill climbing: the search for the pose of one scan. Source: section 5.3.
class RrhcSearch {
 public:
  using Fitness = std::function<double(const Pose2&)>;

  /// parameters, random: outlive the search. The numbers that it draws are the next ones of `random`.
  RrhcSearch(const MatchParameters& parameters, Fitness fitness, Random& random)
      : parameters_(parameters), fitness_(std::move(fitness)), random_(random) {}

  /// Climbs from the initial guess, then again and again from random ones in a window around it.
  SearchResult Run(const SearchTask& task);

 private:
  ScoredPose Draw(const Pose2& pose, const MotionBounds& bounds, int num_draws);
  ScoredPose Climb(const ScoredPose& start);
  ScoredPose ClimbFixed(ScoredPose climber);
  ScoredPose ClimbShrinking(ScoredPose climber);
  ScoredPose Evaluate(const Pose2& pose);
  bool Finished(const ScoredPose& best) const;

  const MatchParameters& parameters_;
  Fitness fitness_;
  Random& random_;
  int evaluations_ = 0;
  int last_evaluation_ = 0;
  int best_evaluation_ = 0;
  double best_fitness_ = -HUGE_VAL;
};

}  // namespace crsm
