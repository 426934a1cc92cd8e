#include "common/match/known_rays.hpp"

#include <vector>

#include "common/match/ray_walk.hpp"

namespace crsm {
namespace {

/// Whether a ray passes through a wall, and not just before it ends: along a wall that is seen flat it may touch it.
bool PassesWall(const ByteMap& map, const Pose2& laser, const Eigen::Vector2d& ray_m,
                const MatchConstants::KnownRays& constants) {
  const double range_m = ray_m.norm();
  return IsInTheWay(map, laser, ray_m / range_m, map.geometry().cell_size_m(), range_m - constants.before_end_m,
                    IsOccupied, constants.walk);
}

/// Whether a place is just behind a wall. The cells behind a wall are unexplored as those beyond its drawn end are; but
/// of a ray that ends behind it the map says that the laser is too close to it.
bool IsBehindWall(const ByteMap& map, const Eigen::Vector2d& place_m, const DegenerateAxis& axis) {
  const int reach_cells = axis.constants.behind_wall_cells;
  const int width_cells = axis.constants.beside_axis_cells;
  const double cell_size_m = map.geometry().cell_size_m();
  const Eigen::Vector2d& along = axis.direction;
  const Eigen::Vector2d across(-along.y(), along.x());
  CellReader cells(map);
  const auto IsWall = [&](int i, int j) {
    const Eigen::Vector2d at_m = place_m + cell_size_m * (i * along + j * across);
    return IsOccupied(cells.At(map.geometry().CellAt(at_m.x(), at_m.y())));
  };
  for (int i = -reach_cells; i <= reach_cells; ++i) {
    if (IsWall(0, i)) return true;
    int num_across = 0;
    for (int j = -width_cells; !axis.held_by_wheels && j <= width_cells; ++j) num_across += IsWall(i, j);
    if (num_across >= axis.constants.least_across_cells) return true;
  }
  return false;
}

}  // namespace

KnownRays FindKnownRays(const ByteMap& map, const Eigen::Matrix2Xd& points_m, const Pose2& T_map_laser,
                        const DegenerateAxis& axis, const KnownRays& among) {
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  KnownRays known = among;
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    if (!known[i]) continue;
    const Eigen::Vector2d ray_m(cos * points_m(0, i) - sin * points_m(1, i),
                                sin * points_m(0, i) + cos * points_m(1, i));
    const Eigen::Vector2d end_m(T_map_laser.x_m + ray_m.x(), T_map_laser.y_m + ray_m.y());
    known[i] = map.At(map.geometry().CellAt(end_m.x(), end_m.y())) != kUnexploredByte ||
               PassesWall(map, T_map_laser, ray_m, axis.constants) || IsBehindWall(map, end_m, axis);
  }
  return known;
}

KnownRays FindKnownRays(const ByteMap& map, const Eigen::Matrix2Xd& points_m, const Pose2& T_map_laser,
                        const DegenerateAxis& axis) {
  return FindKnownRays(map, points_m, T_map_laser, axis, KnownRays::Constant(points_m.cols(), true));
}

RaysInCells SelectRays(const ScoredMap& map, const Contour& contour, const KnownRays& rays) {
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    if (rays[i]) chosen.push_back(i);
  }
  return map.InCells(contour.points_m(Eigen::all, chosen), contour.weights(chosen));
}

double ComputeGain(const ScoredMap& map, const Contour& contour, const DegenerateAxis& axis, const Pose2& from,
                   const KnownRays& known_from, const Pose2& to, bool smooth) {
  const KnownRays known = FindKnownRays(map.cells(), contour.points_m, to, axis, known_from);
  const RaysInCells rays = SelectRays(map, contour, known);
  const double share = static_cast<double>(rays.total_weight()) / static_cast<double>(contour.weights.sum());
  const auto Fit = [&](const Pose2& pose) { return smooth ? map.SmoothFitness(rays, pose) : map.Fitness(rays, pose); };
  return share * (Fit(to) - Fit(from));
}

}  // namespace crsm
