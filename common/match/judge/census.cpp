#include "common/match/judge/census.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/match/fit/rays_in_cells.hpp"
#include "common/math/columns.hpp"

namespace crsm {

RayReader::RayReader(const ByteMap& map, const MatchConstants::Census& constants)
    : map_(map),
      geometry_(map.geometry()),
      constants_(constants),
      tolerance_m_(std::max(constants.tolerance_m, geometry_.cell_size_m())),
      tile_(map.tiles().Find(index_)) {}

RayFate RayReader::FindFate(const Pose2& laser, const Eigen::Vector2d& ray_m) {
  constexpr int kStepBits = 32;  // coordinates are whole numbers of 2^-32 cells: a step is two additions
  constexpr double kOne = static_cast<double>(std::int64_t{1} << kStepBits);
  const double range_m = std::sqrt(ray_m.squaredNorm());
  const double last_m = range_m + tolerance_m_;
  const double step_m = std::max(geometry_.cell_size_m(), last_m / constants_.most_steps);
  const Eigen::Vector2d direction = ray_m / range_m;
  const Eigen::Vector2d laser_m(laser.x_m, laser.y_m);
  const Eigen::Vector2d to_m = laser_m + last_m * direction;
  if (!geometry_.InLimits(laser.x_m, laser.y_m, 0.0) || !geometry_.InLimits(to_m.x(), to_m.y(), 0.0)) {
    return RayFate::kUnknown;
  }
  const auto Fixed = [&](double length_m) { return static_cast<std::int64_t>(geometry_.ToCells(length_m) * kOne); };
  const std::int64_t dx = Fixed(step_m * direction.x());
  const std::int64_t dy = Fixed(step_m * direction.y());
  const std::int64_t x = Fixed(laser.x_m);
  const std::int64_t y = Fixed(laser.y_m);
  const auto Stands = [&](int step) {
    return IsOccupied(
        At({static_cast<int>((x + step * dx) >> kStepBits), static_cast<int>((y + step * dy) >> kStepBits)}));
  };
  const auto NumSteps = [&](double until_m) { return static_cast<int>(std::ceil(until_m / step_m)); };
  // Along a wall that is seen flat it may touch it just before its end.
  const int before_end = NumSteps(range_m - constants_.before_end_m);
  const int at_end = NumSteps(range_m - tolerance_m_);
  const int num_steps = NumSteps(last_m);
  for (int step = 0, num = 0; step <= num_steps; ++step) {
    if (!Stands(step)) continue;
    if (step >= at_end && num == 0) return RayFate::kFits;
    if (++num >= constants_.least_cells && step < before_end) return RayFate::kPasses;
  }
  return At(laser.x_m + ray_m.x(), laser.y_m + ray_m.y()) == kUnexploredByte ? RayFate::kUnknown
                                                                             : RayFate::kContradicts;
}

namespace {

/// Calls `count` with a reader and each ray, map frame, seen from the laser.
template <class Count>
void ForEachRay(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, double yaw_rad,
                const MatchConstants::Census& constants, Count&& count) {
  RayReader reader(map, constants);
  const auto [sin, cos] = ComputeSinCos(yaw_rad);
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    count(reader, Eigen::Vector2d(cos * hits_m(0, i) - sin * hits_m(1, i), sin * hits_m(0, i) + cos * hits_m(1, i)));
  }
}

double ComputeShare(int num, Eigen::Index of) {
  return of > 0 ? static_cast<double>(num) / static_cast<double>(of) : 0.0;
}

}  // namespace

Census CountRays(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                 const MatchConstants::Census& constants) {
  std::array<int, 4> num{};
  ForEachRay(map, hits_m, T_map_laser.yaw_rad, constants, [&](RayReader& reader, const Eigen::Vector2d& ray_m) {
    ++num[static_cast<std::size_t>(reader.FindFate(T_map_laser, ray_m))];
  });
  const auto Share = [&](RayFate fate) { return ComputeShare(num[static_cast<std::size_t>(fate)], hits_m.cols()); };
  return {Share(RayFate::kFits), Share(RayFate::kPasses), Share(RayFate::kContradicts), Share(RayFate::kUnknown)};
}

double FindUnexploredShare(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser) {
  int num = 0;
  ForEachRay(map, hits_m, T_map_laser.yaw_rad, {}, [&](RayReader& reader, const Eigen::Vector2d& ray_m) {
    num += reader.At(T_map_laser.x_m + ray_m.x(), T_map_laser.y_m + ray_m.y()) == kUnexploredByte;
  });
  return ComputeShare(num, hits_m.cols());
}

double ScorePlace(const ScoredMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& T_map_laser,
                  const MatchConstants& constants) {
  const Eigen::Matrix2Xd thinned_m = ThinColumns(hits_m, constants.map_search.most_points);
  return map.Fitness(ToCells(thinned_m, map.geometry()), T_map_laser) *
         CountRays(map.cells(), thinned_m, T_map_laser, constants.census).fits;
}

}  // namespace crsm
