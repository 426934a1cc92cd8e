#include "common/match/search/rrhc_search.hpp"

namespace crsm {

SearchResult RrhcSearch::Run(const SearchTask& task) {
  evaluations_ = best_evaluation_ = 0;
  best_fitness_ = -HUGE_VAL;
  last_evaluation_ = task.num_evaluations;
  ScoredPose best = Climb(Evaluate(task.initial_guess));
  while (!Finished(best) && best.fitness < task.enough) {
    const ScoredPose climbed = Climb(Draw(task.initial_guess, task.window, task.num_draws));
    if (climbed.fitness > best.fitness) best = climbed;
  }
  return {best, evaluations_, best_evaluation_};
}

/// The best of some random poses around one.
ScoredPose RrhcSearch::Draw(const Pose2& pose, const MotionBounds& bounds, int num_draws) {
  ScoredPose best = Evaluate(Mutate(pose, bounds, random_));
  for (int i = 1; i < num_draws && !Finished(best); ++i) {
    const ScoredPose drawn = Evaluate(Mutate(pose, bounds, random_));
    if (drawn.fitness > best.fitness) best = drawn;
  }
  return best;
}

/// Mutates with smaller and smaller steps: each child that fails to beat its parent narrows the bounds.
ScoredPose RrhcSearch::Climb(ScoredPose climber) {
  const MotionBounds bounds{constants_.mutation, constants_.mutation};
  for (double scale = 1.0; scale > constants_.smallest && !Finished(climber);) {
    const ScoredPose child = Evaluate(Mutate(climber.pose, scale * bounds, random_));
    if (child.fitness > climber.fitness) {
      climber = child;
      continue;
    }
    scale *= constants_.shrink;
  }
  return climber;
}

ScoredPose RrhcSearch::Evaluate(const Pose2& pose) {
  ++evaluations_;
  const double fitness = fitness_(pose);
  if (fitness > best_fitness_) {
    best_fitness_ = fitness;
    best_evaluation_ = evaluations_;
  }
  return {pose, fitness};
}

bool RrhcSearch::Finished(const ScoredPose& best) const {
  return evaluations_ >= last_evaluation_ || best.fitness >= 1.0;
}

}  // namespace crsm
