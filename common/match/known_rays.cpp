#include "common/match/known_rays.hpp"

#include <vector>

#include "common/match/ray_walk.hpp"

namespace crsm {
namespace {

/// Whether a ray passes through a wall, and not just before it ends: along a wall that is seen flat it may touch it.
bool PassesWall(const ByteMap& map, const Pose2& laser, const Eigen::Vector2d& ray_m) {
  constexpr double kBefore_m = 0.5;
  const double range_m = ray_m.norm();
  return IsInTheWay(map, laser, ray_m / range_m, map.geometry().cell_size_m(), range_m - kBefore_m, IsOccupied);
}

}  // namespace

KnownRays FindKnownRays(const ByteMap& map, const Eigen::Matrix2Xd& points_m, const Pose2& T_map_laser,
                        const KnownRays& among) {
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  KnownRays known = among;
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    if (!known[i]) continue;
    const Eigen::Vector2d ray_m(cos * points_m(0, i) - sin * points_m(1, i),
                                sin * points_m(0, i) + cos * points_m(1, i));
    const Cell end = map.geometry().CellAt(T_map_laser.x_m + ray_m.x(), T_map_laser.y_m + ray_m.y());
    known[i] = map.At(end) != kUnexploredByte || PassesWall(map, T_map_laser, ray_m);
  }
  return known;
}

KnownRays FindKnownRays(const ByteMap& map, const Eigen::Matrix2Xd& points_m, const Pose2& T_map_laser) {
  return FindKnownRays(map, points_m, T_map_laser, KnownRays::Constant(points_m.cols(), true));
}

RaysInCells SelectRays(const ScoredMap& map, const Outline& outline, const KnownRays& rays) {
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    if (rays[i]) chosen.push_back(i);
  }
  return map.InCells(outline.points_m(Eigen::all, chosen), outline.weights(chosen));
}

double ComputeGain(const ScoredMap& map, const Outline& outline, const Pose2& from, const KnownRays& known_from,
                   const Pose2& to, bool smooth) {
  const KnownRays known = FindKnownRays(map.cells(), outline.points_m, to, known_from);
  const RaysInCells rays = SelectRays(map, outline, known);
  const double share = static_cast<double>(rays.total_weight()) / static_cast<double>(outline.weights.sum());
  const auto Fit = [&](const Pose2& pose) { return smooth ? map.SmoothFitness(rays, pose) : map.Fitness(rays, pose); };
  return share * (Fit(to) - Fit(from));
}

}  // namespace crsm
