// Single matches whose true pose is known: whether the search misses it, or the map misleads it.

#include <cmath>

#include "common/match/default_matcher.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/match/fit/scored_map.hpp"
#include "common/math/random.hpp"
#include "common/scan/hits.hpp"
#include "common/slam.hpp"
#include "services/sources/open_laser_source.hpp"
#include "tests/experiments/outcome.hpp"
#include "tests/experiments/setup.hpp"

namespace crsm {
namespace {

/// Adds up what single matches show.
class Matches {
 public:
  Matches(double cell_size_m, const ScoreRules& rules) : map_(cell_size_m, rules) {}

  void Apply(const std::vector<TileChange>& changes) { map_.Apply(changes); }

  /// `last`, `truth`: the pose of the last scan, and from there as the robot truly moved.
  void Add(const CriticalRays& scan, const Pose2& last, const Pose2& truth, const ScanMatch& match) {
    const double cell_size_m = map_.geometry().cell_size_m();
    const Pose2 motion = Inverse(last) * truth;
    const double length_m = std::hypot(motion.x_m, motion.y_m);
    if (length_m < 0.5 * cell_size_m || scan.critical.empty()) return;  // it turns on the spot
    const Eigen::Matrix2Xd all_hits_m = ComputeHits(scan.rays);
    Eigen::Matrix2Xd hits_m(2, static_cast<Eigen::Index>(scan.critical.size()));
    for (Eigen::Index i = 0; i < hits_m.cols(); ++i)
      hits_m.col(i) = all_hits_m.col(scan.critical[static_cast<std::size_t>(i)]);
    const RaysInCells seen = ToCells(hits_m, map_.geometry());
    const auto Fitness = [&](const Pose2& pose) { return map_.Fitness(seen, pose); };

    const double last_fitness = Fitness(last);
    const double true_fitness = Fitness(truth);
    const double found_fitness = Fitness(match.T_map_laser);
    const Pose2 error = Inverse(truth) * match.T_map_laser;
    const Pose2 found = Inverse(last) * match.T_map_laser;
    const double error_m = std::hypot(error.x_m, error.y_m);
    const bool off = error_m > cell_size_m;
    last_fitness_ += last_fitness;
    true_fitness_ += true_fitness;
    found_fitness_ += found_fitness;
    if (off) (found_fitness < true_fitness ? missed_ : misled_) += 1.0;
    way_m_ += (found.x_m * motion.x_m + found.y_m * motion.y_m) / length_m;
    true_way_m_ += length_m;
    if (std::fmod(num_++, 50.0) == 0.0) Draw(Fitness, last, last_fitness, static_cast<std::uint64_t>(match.utime));
  }

  Outcome Result() const {
    Outcome outcome;
    outcome.last_fitness = last_fitness_ / num_;
    outcome.true_fitness = true_fitness_ / num_;
    outcome.found_fitness = found_fitness_ / num_;
    outcome.missed = missed_ / num_;
    outcome.misled = misled_ / num_;
    outcome.way = way_m_ / true_way_m_;
    outcome.draws = better_draws_ / draws_;
    return outcome;
  }

 private:
  /// Counts how many random poses of the window fit better than the last pose.
  template <class Fitness>
  void Draw(Fitness&& fitness, const Pose2& last, double last_fitness, std::uint64_t stream) {
    constexpr int kDraws = 20000;
    const PaperMatchConstants match;  // ours has the same window
    Random random(1, stream);
    for (int i = 0; i < kDraws; ++i) {
      const double dx_m = random.Uniform(-match.window_m, match.window_m);
      const double dy_m = random.Uniform(-match.window_m, match.window_m);
      const double dyaw_rad = random.Uniform(-match.window_rad, match.window_rad);
      if (fitness(Pose2{last.x_m + dx_m, last.y_m + dy_m, last.yaw_rad + dyaw_rad}) > last_fitness) ++better_draws_;
    }
    draws_ += kDraws;
  }

  ScoredMap map_;
  double num_ = 0.0;
  double last_fitness_ = 0.0;
  double true_fitness_ = 0.0;
  double found_fitness_ = 0.0;
  double missed_ = 0.0;
  double misled_ = 0.0;
  double way_m_ = 0.0;
  double true_way_m_ = 0.0;
  double better_draws_ = 0.0;
  double draws_ = 0.0;
};

}  // namespace

Outcome MeasureMatches(const Run& run) {
  const auto& [parameters, parts, constants] = SetUp(run);
  const auto source = OpenLaserSource("sim:" + run.world, {static_cast<std::uint64_t>(run.seed)});
  const double cell_size_m = parameters.update.cell_size_m;
  RaySelector selector(parameters.scan, parts.select ? parts.select : DefaultSelection(parameters));
  const auto matcher = DefaultMatcher(parameters, constants.match, constants.paper_match)(cell_size_m);
  MapUpdater updater({parameters.update, constants.drawing, constants.paper_drawing});
  const bool is_paper = run.profile == "paper";
  Matches matches(cell_size_m, is_paper ? ScoreRules{constants.paper_match.unexplored_score, false} : ScoreRules{});
  TrackingState tracking;
  Pose2 T_map_laser_before;  // the true one of the scan before
  while (const auto scan = source->Next()) {
    const Pose2 T_map_laser = *source->TruePose();
    const CriticalRays rays = selector.Select(*scan);
    ScanMatch match = matcher->Match(rays, tracking, {});
    if (!tracking.empty()) {
      const Pose2& last = tracking.recent().back().T_map_laser;
      const Pose2 truth = last * (Inverse(T_map_laser_before) * T_map_laser);
      matches.Add(rays, last, truth, match);
    }
    T_map_laser_before = T_map_laser;
    if (run.measured == Measured::kRightMap) {
      match.T_map_laser = T_map_laser;
      if (!tracking.empty()) match.state = MatchState::kOk;
    }
    const MapDelta delta = updater.Update(rays, match);
    matcher->Apply(delta.tiles);
    matches.Apply(delta.tiles);
    tracking.Add(match);
  }
  return matches.Result();
}

}  // namespace crsm
