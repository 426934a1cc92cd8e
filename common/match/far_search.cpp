#include "common/match/far_search.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/math/columns.hpp"

namespace crsm {
namespace {

/// Hits that are near, evenly spread; no more than needed.
Eigen::Matrix2Xd ThinOut(const Eigen::Matrix2Xd& hits_m, const MatchConstants::FarSearch& constants) {
  const Eigen::Matrix2Xd some_m = ThinColumns(hits_m, constants.most_points);
  std::vector<Eigen::Vector2d> near;
  for (const auto& hit_m : some_m.colwise()) {
    if (hit_m.squaredNorm() <= constants.farthest_m * constants.farthest_m) near.emplace_back(hit_m);
  }
  return JoinColumns<Eigen::Matrix2Xd>(near);
}

/// Occupied cells of a map within a square, map frame.
Eigen::Matrix2Xd CollectOccupied(const ByteMap& map, const Pose2& middle, double reach_m) {
  std::vector<Eigen::Vector2d> found;
  const double cell_m = map.geometry().cell_size_m();
  const double tile_m = kTileSide * cell_m;
  const auto IsNear = [&](double x_m, double y_m, double more_m) {
    return std::abs(x_m - middle.x_m) <= reach_m + more_m && std::abs(y_m - middle.y_m) <= reach_m + more_m;
  };
  for (const auto& [index, tile] : map.tiles().entries()) {
    const Cell first = CellAt(index, 0);
    if (!IsNear((first.x + 0.5 * kTileSide) * cell_m, (first.y + 0.5 * kTileSide) * cell_m, tile_m)) continue;
    for (int offset = 0; offset < kTileCells; ++offset) {
      if (!IsOccupied(tile->cells[static_cast<std::size_t>(offset)])) continue;
      const Cell cell = CellAt(index, offset);
      const Eigen::Vector2d at_m((cell.x + 0.5) * cell_m, (cell.y + 0.5) * cell_m);
      if (IsNear(at_m.x(), at_m.y(), 0.0)) found.push_back(at_m);
    }
  }
  return JoinColumns<Eigen::Matrix2Xd>(found);
}

}  // namespace

std::optional<PlaceReach> FindFarWindow(std::span<const ScanMatch> recent, std::int64_t utime,
                                        const MatchConstants::FarSearch& constants) {
  if (recent.size() < 2 || recent.back().state == MatchState::kLost) return std::nullopt;
  const double elapsed_s = 1e-6 * static_cast<double>(utime - recent.back().utime);
  const double usual_s =
      1e-6 * static_cast<double>(recent.back().utime - recent.front().utime) / static_cast<double>(recent.size() - 1);
  if (elapsed_s < constants.close_s || usual_s < constants.close_s) return std::nullopt;
  double farthest_m = 0.0;
  double widest_rad = 0.0;
  for (std::size_t i = 1; i < recent.size(); ++i) {
    if (!IsMotionMatched(recent[i - 1], recent[i])) continue;
    const Pose2 motion = Inverse(recent[i - 1].T_map_laser) * recent[i].T_map_laser;
    farthest_m = std::max(farthest_m, Length(motion));
    widest_rad = std::max(widest_rad, std::abs(motion.yaw_rad));
  }
  const double faster_m = std::min(constants.faster_m_s * elapsed_s, constants.faster_most_m);
  return PlaceReach{
      std::min(constants.least_m + faster_m + farthest_m, constants.most_m),
      std::min(constants.least_rad + constants.faster_rad_s * elapsed_s + widest_rad, constants.most_rad)};
}

std::optional<Pose2> SearchFar(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& initial_guess,
                               const PlaceReach& reach, const MatchConstants& constants) {
  const MatchConstants::FarSearch& far = constants.far_search;
  const Eigen::Matrix2Xd points_m = ThinOut(hits_m, far);
  if (points_m.cols() < far.fewest_points) return std::nullopt;
  const HitPyramid pyramid(CollectOccupied(map, initial_guess, reach.reach_m + far.farthest_m), far.cell_m);
  const Place place =
      FindPlace(pyramid, points_m, {initial_guess, reach.reach_m, reach.reach_rad},
                {far.farthest_m, far.least_score, far.rival_share, far.most_evaluations, constants.place_search});
  if (place.score == 0.0 || place.rival > 0.0) return std::nullopt;
  return place.pose;
}

}  // namespace crsm
