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

Individual RrhcSearch::Run(const Pose2& presumed, const MotionBounds& window, int num_draws, int num_evaluations,
                           double enough) {
  constexpr int kMinClimbs = 3;
  last_evaluation_ = evaluations_ + num_evaluations;
  Individual best = Climb(Evaluate(presumed));
  for (int climbs = 1; !Finished(best) && (climbs < kMinClimbs || best.fitness < enough); ++climbs) {
    const Individual climbed = Climb(Draw(presumed, window, num_draws));
    if (climbed.fitness > best.fitness) best = climbed;
  }
  return best;
}

/// The best of some random poses around one.
Individual RrhcSearch::Draw(const Pose2& pose, const MotionBounds& bounds, int num_draws) {
  Individual best = Evaluate(Mutate(pose, bounds, random_));
  for (int i = 1; i < num_draws && !Finished(best); ++i) {
    const Individual drawn = Evaluate(Mutate(pose, bounds, random_));
    if (drawn.fitness > best.fitness) best = drawn;
  }
  return best;
}

Individual RrhcSearch::Climb(const Individual& start) {
  return parameters_.climb == ClimbMode::kFixed ? ClimbFixed(start) : ClimbShrinking(start);
}

/// Mutates for as long as every child beats its parent: the text of the paper.
Individual RrhcSearch::ClimbFixed(Individual individual) {
  const MotionBounds bounds{parameters_.mutation_m, parameters_.mutation_rad};
  while (!Finished(individual)) {
    const Individual child = Evaluate(Mutate(individual.pose, bounds, random_));
    if (child.fitness <= individual.fitness) break;
    individual = child;
  }
  return individual;
}

/// Mutates with smaller and smaller steps: each child that fails to beat its parent narrows the bounds.
Individual RrhcSearch::ClimbShrinking(Individual individual) {
  constexpr double kShrink = 0.85;
  constexpr double kSmallest = 0.02;
  const MotionBounds bounds{parameters_.mutation_m, parameters_.mutation_rad};
  for (double scale = 1.0; scale > kSmallest && !Finished(individual);) {
    const Individual child = Evaluate(Mutate(individual.pose, scale * bounds, random_));
    if (child.fitness > individual.fitness) {
      individual = child;
    } else {
      scale *= kShrink;
    }
  }
  return individual;
}

Individual RrhcSearch::Evaluate(const Pose2& pose) {
  ++evaluations_;
  const double fitness = fitness_(pose);
  if (fitness > best_fitness_) {
    best_fitness_ = fitness;
    best_evaluation_ = evaluations_;
  }
  return {pose, fitness};
}

bool RrhcSearch::Finished(const Individual& best) const {
  return evaluations_ >= last_evaluation_ || best.fitness >= parameters_.satisfying_fitness;
}

}  // namespace crsm
