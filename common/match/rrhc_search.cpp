#include "common/match/rrhc_search.hpp"

namespace crsm {
namespace {

Pose2 Mutate(const Pose2& pose, const MotionBounds& bounds, Random& random) {
  const double dx_m = random.Uniform(-bounds.x_m, bounds.x_m);
  const double dy_m = random.Uniform(-bounds.x_m, bounds.x_m);
  const double dyaw_rad = random.Uniform(-bounds.yaw_rad, bounds.yaw_rad);
  return {pose.x_m + dx_m, pose.y_m + dy_m, pose.yaw_rad + dyaw_rad};
}

}  // namespace

SearchResult RrhcSearch::Run(const SearchTask& task) {
  constexpr int kMinClimbs = 3;  // one climb alone may end on an optimum beside the highest, and be good enough there
  evaluations_ = best_evaluation_ = 0;
  best_fitness_ = -HUGE_VAL;
  last_evaluation_ = task.num_evaluations;
  ScoredPose best = Climb(Evaluate(task.initial_guess));
  for (int climbs = 1; !Finished(best) && (climbs < kMinClimbs || best.fitness < task.enough); ++climbs) {
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

ScoredPose RrhcSearch::Climb(const ScoredPose& start) {
  return parameters_.climb == ClimbMode::kFixed ? ClimbFixed(start) : ClimbShrinking(start);
}

/// Mutates for as long as every child beats its parent: the text of the paper.
ScoredPose RrhcSearch::ClimbFixed(ScoredPose climber) {
  const MotionBounds bounds{parameters_.mutation_m, parameters_.mutation_rad};
  while (!Finished(climber)) {
    const ScoredPose child = Evaluate(Mutate(climber.pose, bounds, random_));
    if (child.fitness <= climber.fitness) break;
    climber = child;
  }
  return climber;
}

/// Mutates with smaller and smaller steps: each child that fails to beat its parent narrows the bounds. With steps half
/// as long a climber that is far below the highest of the search will not get there any more, and gives up.
ScoredPose RrhcSearch::ClimbShrinking(ScoredPose climber) {
  // 38 failures narrow the bounds to a fiftieth: 2 mm, and as many milliradians.
  constexpr double kShrink = 0.9;
  constexpr double kSmallest = 0.02;
  constexpr double kHalf = 0.5;
  constexpr double kFar = 0.3;  // of the highest
  const MotionBounds bounds{parameters_.mutation_m, parameters_.mutation_rad};
  for (double scale = 1.0; scale > kSmallest && !Finished(climber);) {
    const ScoredPose child = Evaluate(Mutate(climber.pose, scale * bounds, random_));
    if (child.fitness > climber.fitness) {
      climber = child;
    } else {
      scale *= kShrink;
      if (scale < kHalf && best_fitness_ - climber.fitness > kFar * std::abs(best_fitness_)) break;
    }
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
  return evaluations_ >= last_evaluation_ || best.fitness >= parameters_.satisfying_fitness;
}

}  // namespace crsm
