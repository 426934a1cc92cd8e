#include "common/rrhc_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "common/random.hpp"

namespace crsm {
namespace {

/// A pose and how well the rays fit there.
struct Individual {
  Pose2 pose;
  double fitness = 0.0;
};

/// Bounds of a random change of the genome [Dx, Dy, Dtheta] (section 5.1).
struct Bounds {
  double x_m;  ///< and y
  double yaw_rad;

  friend Bounds operator*(double factor, const Bounds& bounds) { return {factor * bounds.x_m, factor * bounds.yaw_rad}; }
};

Pose2 Mutate(const Pose2& pose, const Bounds& bounds, Random& random) {
  const double dx_m = random.Uniform(-bounds.x_m, bounds.x_m);
  const double dy_m = random.Uniform(-bounds.x_m, bounds.x_m);
  const double dyaw_rad = random.Uniform(-bounds.yaw_rad, bounds.yaw_rad);
  return {pose.x_m + dx_m, pose.y_m + dy_m, pose.yaw_rad + dyaw_rad};
}

/// One search for the pose of one scan.
class Search {
 public:
  using Fitness = std::function<double(const Pose2&)>;

  Search(const MatchParameters& parameters, Fitness fitness, Random random)
      : parameters_(parameters), fitness_(std::move(fitness)), random_(random) {}

  /// Climbs from the presumed pose, then again and again from random ones around it (section 5.3).
  Individual Run(const Pose2& presumed) {
    const Bounds window{parameters_.window_m, parameters_.window_rad};
    Individual best = Climb(Evaluate(presumed));
    while (!Finished(best)) {
      const Individual climbed = Climb(Evaluate(Mutate(presumed, window, random_)));
      if (climbed.fitness > best.fitness) best = climbed;
    }
    return best;
  }

  int evaluations() const { return evaluations_; }

 private:
  Individual Climb(Individual individual) {
    return parameters_.climb == ClimbMode::kFixed ? ClimbFixed(individual) : ClimbShrinking(individual);
  }

  /// Mutates for as long as every child beats its parent: the text of the paper.
  Individual ClimbFixed(Individual individual) {
    const Bounds bounds{parameters_.mutation_m, parameters_.mutation_rad};
    while (!Finished(individual)) {
      const Individual child = Evaluate(Mutate(individual.pose, bounds, random_));
      if (child.fitness <= individual.fitness) break;
      individual = child;
    }
    return individual;
  }

  /// Mutates with smaller and smaller steps: each child that fails to beat its parent narrows the bounds.
  Individual ClimbShrinking(Individual individual) {
    constexpr double kShrink = 0.85;
    constexpr double kSmallest = 0.02;
    const Bounds bounds{parameters_.mutation_m, parameters_.mutation_rad};
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

  bool Finished(const Individual& best) const {
    return evaluations_ >= parameters_.num_evaluations || best.fitness >= parameters_.satisfying_fitness;
  }

  Individual Evaluate(const Pose2& pose) {
    ++evaluations_;
    return {pose, fitness_(pose)};
  }

  const MatchParameters& parameters_;
  Fitness fitness_;
  Random random_;
  int evaluations_ = 0;
};

/// Climbs to the nearest summit by steps along each axis that halve when none leads up.
template <class Fitness>
Individual ClimbToSummit(Individual individual, Bounds bounds, int num_halvings, Fitness&& fitness, int& evaluations) {
  for (int halving = 0; halving < num_halvings;) {
    bool climbed = false;
    for (const Pose2 step : {Pose2{bounds.x_m, 0, 0}, Pose2{0, bounds.x_m, 0}, Pose2{0, 0, bounds.yaw_rad}}) {
      for (const double sign : {1.0, -1.0}) {
        const Pose2& at = individual.pose;
        const Pose2 next{at.x_m + sign * step.x_m, at.y_m + sign * step.y_m, at.yaw_rad + sign * step.yaw_rad};
        ++evaluations;
        const double value = fitness(next);
        if (value <= individual.fitness) continue;
        individual = {next, value};
        climbed = true;
        break;
      }
    }
    if (climbed) continue;
    bounds = 0.5 * bounds;
    ++halving;
  }
  return individual;
}

Eigen::Matrix2Xd Columns(const Eigen::Matrix2Xd& all, std::span<const int> picked) {
  Eigen::Matrix2Xd columns(2, static_cast<Eigen::Index>(picked.size()));
  for (std::size_t i = 0; i < picked.size(); ++i) columns.col(static_cast<Eigen::Index>(i)) = all.col(picked[i]);
  return columns;
}

}  // namespace

Pose2 PredictPose(std::span<const ScanMatch> history, std::int64_t utime, const MatchParameters& parameters) {
  const ScanMatch& last = history.back();
  if (!parameters.velocity_model || history.size() < 2) return last.T_map_laser;
  const ScanMatch& before = history[history.size() - 2];
  const Pose2 motion = Inverse(before.T_map_laser) * last.T_map_laser;
  constexpr double kMaxRatio = 3.0;
  const double ratio = static_cast<double>(utime - last.utime) / static_cast<double>(last.utime - before.utime);
  const bool believable = ratio > 1.0 / kMaxRatio && ratio < kMaxRatio;  // false for NaN
  const double share = believable ? ratio : 1.0;
  return last.T_map_laser * Pose2{share * motion.x_m, share * motion.y_m, share * motion.yaw_rad};
}

RrhcMatcher::RrhcMatcher(const MatchParameters& parameters)
    : parameters_(parameters), field_(parameters.unexplored_score, parameters.interpolate) {}

bool RrhcMatcher::ApplyChanges(std::span<const TileChange> changes) {
  bool well_formed = true;
  std::vector<TileIndex> changed;
  for (const TileChange& change : changes) {
    if (map_.Apply(change)) {
      changed.push_back(change.index);
    } else {
      well_formed = false;
    }
  }
  field_.Refresh(map_, changed);
  return well_formed;
}

ScanMatch RrhcMatcher::Match(std::int64_t utime, const ValidRays& rays, std::span<const int> critical,
                             std::span<const ScanMatch> history, const MapGeometry& geometry,
                             std::int64_t map_version) const {
  ScanMatch match;
  match.utime = utime;
  match.num_critical = static_cast<std::int32_t>(critical.size());
  match.map_version = map_version;
  if (history.empty()) return match;

  const Pose2 presumed = PredictPose(history, utime, parameters_);
  match.T_map_laser = presumed;
  match.state = MatchState::kLost;
  if (critical.empty()) return match;

  const Eigen::Matrix2Xd hits_m = ComputeHits(rays);
  const RaysInCells critical_rays = ToCells(Columns(hits_m, critical), geometry);
  const auto CriticalFitness = [&](const Pose2& pose) { return field_.Evaluate(critical_rays, pose, geometry); };
  Search search(parameters_, CriticalFitness, Random(parameters_.seed, static_cast<std::uint64_t>(utime)));
  Individual best = search.Run(presumed);
  match.evaluations = search.evaluations();

  if (parameters_.final_climb) {
    const RaysInCells all_rays = ToCells(hits_m, geometry);
    const auto AllFitness = [&](const Pose2& pose) { return field_.Evaluate(all_rays, pose, geometry); };
    const Bounds first_step{geometry.cell_size_m(), 0.01};
    constexpr int kHalvings = 6;
    best = ClimbToSummit({best.pose, AllFitness(best.pose)}, first_step, kHalvings, AllFitness, match.evaluations);
    best.fitness = CriticalFitness(best.pose);
  }

  match.T_map_laser = {best.pose.x_m, best.pose.y_m, WrapAngle(best.pose.yaw_rad)};
  match.fitness = std::clamp(best.fitness, 0.0, 1.0);
  match.state = MatchState::kOk;
  return match;
}

}  // namespace crsm
