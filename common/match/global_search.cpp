#include "common/match/global_search.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/match/optimum.hpp"
#include "common/match/rays_in_cells.hpp"
#include "common/math/columns.hpp"

namespace crsm {
namespace {

bool Better(const ScoredPose& a, const ScoredPose& b) { return a.fitness > b.fitness; }

/// Whether two poses are of one place.
bool AreNear(const Pose2& a, const Pose2& b, const MatchConstants::GlobalSearch& constants) {
  return std::abs(a.x_m - b.x_m) <= constants.other_m && std::abs(a.y_m - b.y_m) <= constants.other_m &&
         std::abs(WrapAngle(a.yaw_rad - b.yaw_rad)) <= constants.other_rad;
}

/// The map in larger cells, of `factor` x `factor`: occupied where one of them is, free where one is and none is
/// occupied.
ScoredMap MakeCoarse(const ByteMap& map, int factor) {
  ByteMap coarse(factor * map.geometry().cell_size_m());
  const auto Down = [factor](int cell) { return cell >= 0 ? cell / factor : -((-cell - 1) / factor) - 1; };
  for (const auto& [index, tile] : map.tiles().entries()) {
    for (int offset = 0; offset < kTileCells; ++offset) {
      const std::uint8_t byte = tile->cells[static_cast<std::size_t>(offset)];
      if (byte == kUnexploredByte) continue;
      const Cell fine = CellAt(index, offset);
      const Cell cell{Down(fine.x), Down(fine.y)};
      if (IsOccupied(byte)) coarse.Set(cell, kOccupiedByte);
      if (IsFree(byte) && coarse.At(cell) == kUnexploredByte) coarse.Set(cell, kFreeByte);
    }
  }
  return ScoredMap(std::move(coarse));
}

std::vector<Pose2> FindFreePlaces(const ByteMap& coarse) {
  std::vector<Pose2> places;
  const double cell_m = coarse.geometry().cell_size_m();
  std::map<TileIndex, const ByteMap::Tile*> in_order;  // by place: not by when a tile was explored
  for (const auto& [index, tile] : coarse.tiles().entries()) in_order.emplace(index, tile.get());
  for (const auto& [index, tile] : in_order) {
    for (int offset = 0; offset < kTileCells; ++offset) {
      if (tile->cells[static_cast<std::size_t>(offset)] != kFreeByte) continue;
      const Cell cell = CellAt(index, offset);
      places.push_back({(cell.x + 0.5) * cell_m, (cell.y + 0.5) * cell_m, 0.0});
    }
  }
  return places;
}

/// The best poses on the coarse map, those that the neighbouring directions do not beat.
std::vector<ScoredPose> TryEverywhere(const ScoredMap& coarse, const std::vector<Pose2>& places,
                                      const Eigen::Matrix2Xd& hits_m, const MatchConstants::GlobalSearch& constants,
                                      int& evaluations) {
  const RaysInCells rays = ToCells(hits_m, coarse.geometry());
  const int num = constants.directions;
  std::vector<ScoredPose> best;
  std::vector<double> scores(static_cast<std::size_t>(num));
  for (const Pose2& place : places) {
    const auto At = [&](int direction) { return Pose2{place.x_m, place.y_m, 2.0 * kPi * direction / num - kPi}; };
    for (int i = 0; i < num; ++i) scores[static_cast<std::size_t>(i)] = coarse.Fitness(rays, At(i));
    const auto Score = [&](int direction) { return scores[static_cast<std::size_t>(direction)]; };
    for (int i = 0; i < num; ++i) {
      const double before = Score(i > 0 ? i - 1 : num - 1);
      const double after = Score(i + 1 < num ? i + 1 : 0);
      if (Score(i) > before && Score(i) >= after) best.push_back({At(i), Score(i)});
    }
    evaluations += num;
    if (best.size() < 4 * constants.most_climbs) continue;  // sorted now and then: so they are no more than that
    std::stable_sort(best.begin(), best.end(), Better);
    best.resize(constants.most_climbs);
  }
  std::stable_sort(best.begin(), best.end(), Better);
  if (best.size() > constants.most_climbs) best.resize(constants.most_climbs);
  return best;
}

/// The best of each place, best first; `most` of them.
std::vector<ScoredPose> KeepDistinct(std::vector<ScoredPose> candidates, std::size_t most,
                                     const MatchConstants::GlobalSearch& constants) {
  std::stable_sort(candidates.begin(), candidates.end(), Better);
  std::vector<ScoredPose> distinct;
  for (const ScoredPose& candidate : candidates) {
    if (distinct.size() == most) break;
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const ScoredPose& other) {
      return AreNear(candidate.pose, other.pose, constants);
    });
    if (!known) distinct.push_back(candidate);
  }
  return distinct;
}

}  // namespace

double ComputeAgreement(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                        const MatchConstants::Agreement& constants) {
  const MapGeometry& geometry = map.geometry();
  const double cell_m = geometry.cell_size_m();
  const double tolerance_m = std::max(constants.tolerance_m, constants.tolerance_cells * cell_m);
  if (hits_m.cols() == 0) return 0.0;
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  int num_agreeing = 0;
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const double range_m = std::sqrt(hits_m.col(i).squaredNorm());
    const double dx = (cos * hits_m(0, i) - sin * hits_m(1, i)) / range_m;
    const double dy = (sin * hits_m(0, i) + cos * hits_m(1, i)) / range_m;
    const double step_m = std::max(cell_m, range_m / constants.most_steps);
    const double first_m = std::min(constants.near_m, range_m - tolerance_m);
    for (double way_m = first_m; way_m <= range_m + tolerance_m; way_m += step_m) {
      if (!IsOccupied(map.At(geometry.CellAt(T_map_laser.x_m + way_m * dx, T_map_laser.y_m + way_m * dy)))) continue;
      if (way_m >= range_m - tolerance_m) ++num_agreeing;
      break;
    }
  }
  return static_cast<double>(num_agreeing) / static_cast<double>(hits_m.cols());
}

double ScorePlace(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                  const MatchConstants& constants) {
  const Eigen::Matrix2Xd thinned_m = ThinColumns(hits_m, constants.global_search.most_rays);
  return map.Fitness(ToCells(thinned_m, map.geometry()), T_map_laser) *
         ComputeAgreement(map.cells(), thinned_m, T_map_laser, constants.agreement);
}

GlobalMatch SearchWholeMap(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m,
                           const Eigen::Matrix2Xd& critical_hits_m, const MatchConstants& constants) {
  const MatchConstants::GlobalSearch& search = constants.global_search;
  GlobalMatch match;
  int factor = std::max(1, static_cast<int>(std::lround(search.first_cell_m / map.geometry().cell_size_m())));
  ScoredMap coarse = MakeCoarse(map.cells(), factor);
  std::vector<Pose2> places = FindFreePlaces(coarse.cells());
  while (places.size() > search.most_places) {
    coarse = MakeCoarse(map.cells(), factor *= 2);
    places = FindFreePlaces(coarse.cells());
  }
  const Eigen::Matrix2Xd few_hits_m = ThinColumns(critical_hits_m, search.most_rays);
  std::vector<ScoredPose> candidates = TryEverywhere(coarse, places, few_hits_m, search, match.evaluations);

  // Each of them climbs on finer and finer maps.
  double step_rad = kPi / search.directions;
  const auto ClimbOn = [&](const ScoredMap& there, const Eigen::Matrix2Xd& seen_m, int num_halvings,
                           std::vector<ScoredPose>& climbers) {
    const RaysInCells rays = ToCells(seen_m, there.geometry());
    for (ScoredPose& climber : climbers) {
      climber =
          ClimbToOptimum(climber.pose, there.geometry().cell_size_m(), step_rad, num_halvings, [&](const Pose2& pose) {
            ++match.evaluations;
            return there.Fitness(rays, pose);
          });
    }
    step_rad *= 0.5;
  };
  while ((factor /= 2) > 1) ClimbOn(MakeCoarse(map.cells(), factor), few_hits_m, search.halvings, candidates);
  ClimbOn(map, few_hits_m, search.halvings, candidates);

  // The highest climb on with all rays, and are looked at more closely.
  std::vector<ScoredPose> finalists = KeepDistinct(std::move(candidates), search.most_finalists, search);
  ClimbOn(map, ThinColumns(hits_m, search.most_rays), search.halvings_at_end, finalists);
  for (ScoredPose& finalist : finalists) finalist.fitness = ScorePlace(map, hits_m, finalist.pose, constants);
  finalists = KeepDistinct(std::move(finalists), 2, search);
  if (finalists.empty()) return match;
  match.T_map_laser = finalists[0].pose;
  match.score = finalists[0].fitness;
  match.runner_up = finalists.size() > 1 ? finalists[1].fitness : 0.0;
  return match;
}

}  // namespace crsm
