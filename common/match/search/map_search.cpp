#include "common/match/search/map_search.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/match/fit/optimum.hpp"
#include "common/match/fit/rays_in_cells.hpp"
#include "common/match/judge/census.hpp"
#include "common/math/columns.hpp"

namespace crsm {
namespace {

/// Hits that are near, evenly spread; no more than needed.
Eigen::Matrix2Xd ThinOut(const Eigen::Matrix2Xd& hits_m, const MatchConstants::MapSearch& constants) {
  const Eigen::Matrix2Xd some_m = ThinColumns(hits_m, constants.most_points);
  std::vector<Eigen::Vector2d> near;
  for (const auto& hit_m : some_m.colwise()) {
    if (hit_m.squaredNorm() <= constants.farthest_m * constants.farthest_m) near.emplace_back(hit_m);
  }
  return JoinColumns<Eigen::Matrix2Xd>(near);
}

/// The best pose of a grid around one: all that is less than two cells off lies on the same hits there.
template <class Fitness>
Pose2 FindBestAround(const Pose2& middle, double step_m, double step_rad, int num_steps, Fitness&& fitness) {
  ScoredPose best{middle, -HUGE_VAL};
  for (int yaw = -num_steps; yaw <= num_steps; ++yaw) {
    for (int y = -num_steps; y <= num_steps; ++y) {
      for (int x = -num_steps; x <= num_steps; ++x) {
        const Pose2 pose{middle.x_m + x * step_m, middle.y_m + y * step_m, middle.yaw_rad + yaw * step_rad};
        const double there = fitness(pose);
        if (there > best.fitness) best = {pose, there};
      }
    }
  }
  return best.pose;
}

/// What branch and bound has found on coarse cells, looked at closely.
FoundOnMap SearchPyramid(const HitPyramid& pyramid, const ScoredMap& map, const Eigen::Matrix2Xd& points_m,
                         const PlaceWindow& window, int most_evaluations, const MatchConstants& constants) {
  const MatchConstants::MapSearch& search = constants.map_search;
  const auto [places, highest_left, evaluations] =
      FindPlaces(pyramid, points_m, window,
                 {search.farthest_m, search.least_score, search.rival_share, most_evaluations, search.other_place},
                 search.most_places);
  FoundOnMap found;
  found.evaluations = evaluations;
  const RaysInCells rays = ToCells(points_m, map.geometry());
  const auto Fitness = [&](const Pose2& pose) {
    ++found.evaluations;
    return map.Fitness(rays, pose);
  };
  const double step_m = pyramid.cell_m();
  const double step_rad = step_m / search.farthest_m;
  for (const ScoredPose& place : places) {
    const Pose2 around = FindBestAround(place.pose, step_m, step_rad, search.plateau_steps, Fitness);
    const Pose2 top = ClimbToOptimum(around, 0.5 * step_m, 0.5 * step_rad, search.halvings, Fitness).pose;
    const double score = ScorePlace(map, points_m, top, constants);
    if (score > found.score) {
      found.runner_up = found.score;
      found.score = score;
      found.T_map_laser = top;
    } else {
      found.runner_up = std::max(found.runner_up, score);
    }
  }
  if (highest_left > 0.0) found.runner_up = found.score;  // too much is alike
  return found;
}

}  // namespace

PlaceReach FindReach(std::span<const ScanMatch> recent, std::int64_t utime,
                     const MatchConstants::MapSearch& constants) {
  PlaceReach reach{constants.least_m, constants.least_rad};
  if (recent.empty()) return reach;
  double farthest_m = 0.0;
  double widest_rad = 0.0;
  for (std::size_t i = 1; i < recent.size(); ++i) {
    if (!IsMotionMatched(recent[i - 1], recent[i])) continue;
    const Pose2 motion = Inverse(recent[i - 1].T_map_laser) * recent[i].T_map_laser;
    farthest_m = std::max(farthest_m, Length(motion));
    widest_rad = std::max(widest_rad, std::abs(motion.yaw_rad));
  }
  const auto last = std::find_if(recent.rbegin(), recent.rend() - 1,
                                 [](const ScanMatch& match) { return match.state != MatchState::kLost; });
  const double elapsed_s = std::max(0.0, 1e-6 * static_cast<double>(utime - last->utime));
  reach.reach_m += farthest_m + std::min(constants.faster_m_s * elapsed_s, constants.faster_most_m);
  reach.reach_rad += widest_rad + constants.faster_rad_s * elapsed_s;
  return {std::min(reach.reach_m, constants.most_m), std::min(reach.reach_rad, constants.most_rad)};
}

FoundOnMap SearchMap(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const PlaceWindow& window,
                     const MatchConstants& constants) {
  const MatchConstants::MapSearch& search = constants.map_search;
  const Eigen::Matrix2Xd points_m = ThinOut(hits_m, search);
  if (points_m.cols() < constants.breaks.fewest_rays) return {};
  const Eigen::Vector2d middle_m(window.centre.x_m, window.centre.y_m);
  const Eigen::Vector2d reach_m = Eigen::Vector2d::Constant(window.reach_m + search.farthest_m);
  const HitPyramid pyramid(map.cells(), middle_m - reach_m, middle_m + reach_m, search.cell_m);
  return SearchPyramid(pyramid, map, points_m, window, search.most_evaluations, constants);
}

FoundOnMap SearchWholeMap(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const MatchConstants& constants) {
  const MatchConstants::MapSearch& search = constants.map_search;
  const Eigen::Matrix2Xd points_m = ThinOut(hits_m, search);
  if (points_m.cols() < constants.breaks.fewest_rays || map.cells().empty()) return {};
  const double cell_m = map.geometry().cell_size_m();
  const auto [low, high] = map.cells().FindTiled();
  const Eigen::Vector2d low_m = cell_m * Eigen::Vector2d(low.x, low.y);
  const Eigen::Vector2d high_m = cell_m * Eigen::Vector2d(high.x + 1, high.y + 1);
  const Eigen::Vector2d middle_m = 0.5 * (low_m + high_m);
  const double reach_m = 0.5 * (high_m - low_m).maxCoeff();
  const HitPyramid pyramid(map.cells(), low_m, high_m, std::max(search.cell_m, reach_m / search.most_reach_cells));
  return SearchPyramid(pyramid, map, points_m, {{middle_m.x(), middle_m.y(), 0.0}, reach_m, kPi},
                       search.most_whole_evaluations, constants);
}

}  // namespace crsm
