#pragma once

#include <cmath>
#include <functional>

#include "common/match/fit/scored_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/match/search/mutate.hpp"

namespace crsm {

/// Where to search, and when to stop.
struct SearchTask {
  Pose2 initial_guess;  ///< the first climb starts here
  MotionBounds window;  ///< the later ones somewhere in here around it ...
  int num_draws;        ///< ... each from the best of so many random poses, >= 1
  int num_evaluations;  ///< the search ends when they are spent, >= 1 ...
  double enough;        ///< ... or when the best of all climbs is as good as this
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

  /// constants, random: outlive the search. The numbers that it draws are the next ones of `random`.
  RrhcSearch(const MatchConstants::Search& constants, Fitness fitness, Random& random)
      : constants_(constants), fitness_(std::move(fitness)), random_(random) {}

  /// Climbs from the initial guess, then again and again from random ones in a window around it.
  SearchResult Run(const SearchTask& task);

 private:
  ScoredPose Draw(const Pose2& pose, const MotionBounds& bounds, int num_draws);
  ScoredPose Climb(ScoredPose climber);
  ScoredPose Evaluate(const Pose2& pose);
  bool Finished(const ScoredPose& best) const;

  const MatchConstants::Search& constants_;
  Fitness fitness_;
  Random& random_;
  int evaluations_ = 0;
  int last_evaluation_ = 0;
  int best_evaluation_ = 0;
  double best_fitness_ = -HUGE_VAL;
};

}  // namespace crsm
