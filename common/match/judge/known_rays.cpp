#include "common/match/judge/known_rays.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "common/match/judge/census.hpp"

namespace crsm {
namespace {

/// Whether no cell of a square around one is a wall, by a look at eight cells at a time. False too where that takes
/// more than one tile.
bool IsSurelyClear(const ByteMap& map, Cell middle, int reach_cells) {
  constexpr std::uint64_t kLow = 0x0101010101010101;
  constexpr std::uint64_t kHigh = kLow << 7;
  constexpr int kAtOnce = 8;
  static_assert(kUnexploredByte == 127);  // with 1 more it has the highest bit, as free cells have and walls have not
  const Cell low{middle.x - reach_cells, middle.y - reach_cells};
  const int size = 2 * reach_cells + 1;
  const Cell in_tile{low.x & kTileMask, low.y & kTileMask};
  if (size < kAtOnce || in_tile.x + size > kTileSide || in_tile.y + size > kTileSide) return false;
  const ByteMap::Tile* tile = map.tiles().Find(TileOf(low));
  if (!tile) return true;
  std::uint64_t all_high = kHigh;
  for (int row = 0; row < size; ++row) {
    const std::uint8_t* cells = tile->cells.data() + OffsetInTile({low.x, low.y + row});
    for (int at = 0; at < size; at += kAtOnce) {
      std::uint64_t bytes;
      std::memcpy(&bytes, cells + std::min(at, size - kAtOnce), kAtOnce);
      all_high &= bytes | ((bytes & ~kHigh) + kLow);
    }
  }
  return (all_high & kHigh) == kHigh;
}

/// Whether a place is just behind a wall. The cells behind a wall are unexplored as those beyond its drawn end are; but
/// of a ray that ends behind it the map says that the laser is too close to it.
bool IsBehindWall(const ByteMap& map, RayReader& reader, const Eigen::Vector2d& place_m, const DegenerateAxis& axis) {
  const int reach_cells = axis.constants.behind_wall_cells;
  const int width_cells = axis.constants.beside_axis_cells;
  if (IsSurelyClear(map, map.geometry().CellAt(place_m.x(), place_m.y()), reach_cells + width_cells)) return false;
  const double cell_size_m = map.geometry().cell_size_m();
  const Eigen::Vector2d& along = axis.direction;
  const Eigen::Vector2d across(-along.y(), along.x());
  const auto IsWall = [&](int i, int j) {
    const Eigen::Vector2d at_m = place_m + cell_size_m * (i * along + j * across);
    return IsOccupied(reader.At(at_m.x(), at_m.y()));
  };
  for (int i = -reach_cells; i <= reach_cells; ++i) {
    if (IsWall(0, i)) return true;
    int num_across = 0;
    for (int j = -width_cells; !axis.held_by_wheels && j <= width_cells; ++j) num_across += IsWall(i, j);
    if (num_across > width_cells) return true;
  }
  return false;
}

/// Points of a scan as seen from the laser, map frame.
Eigen::Matrix2Xd Turn(const Eigen::Matrix2Xd& points_m, double yaw_rad) {
  const auto [sin, cos] = ComputeSinCos(yaw_rad);
  Eigen::Matrix2Xd rays_m(2, points_m.cols());
  for (Eigen::Index i = 0; i < points_m.cols(); ++i) {
    rays_m.col(i) << cos * points_m(0, i) - sin * points_m(1, i), sin * points_m(0, i) + cos * points_m(1, i);
  }
  return rays_m;
}

/// As of FindKnownRays, of those that are known so far. rays_m: turned as the laser is.
KnownRays FindKnownOf(const ByteMap& map, const Eigen::Matrix2Xd& rays_m, const Pose2& T_map_laser,
                      const DegenerateAxis& axis, double margin_m, KnownRays known) {
  RayReader reader(map, axis.census);
  const auto Tells = [&](const Eigen::Vector2d& place_m) {
    return reader.At(place_m.x(), place_m.y()) != kUnexploredByte || IsBehindWall(map, reader, place_m, axis);
  };
  for (Eigen::Index i = 0; i < rays_m.cols(); ++i) {
    if (!known[i]) continue;
    const Eigen::Vector2d ray_m = rays_m.col(i);
    const Eigen::Vector2d end_m(T_map_laser.x_m + ray_m.x(), T_map_laser.y_m + ray_m.y());
    const Eigen::Vector2d margin = margin_m * axis.direction;
    const bool is_told = Tells(end_m) && (margin_m == 0.0 || (Tells(end_m + margin) && Tells(end_m - margin)));
    known[i] = is_told || reader.FindFate(T_map_laser, ray_m) == RayFate::kPasses;
  }
  return known;
}

}  // namespace

KnownRays FindKnownRays(const ByteMap& map, const Eigen::Matrix2Xd& points_m, const Pose2& T_map_laser,
                        const DegenerateAxis& axis, double margin_m) {
  return FindKnownOf(map, Turn(points_m, T_map_laser.yaw_rad), T_map_laser, axis, margin_m,
                     KnownRays::Constant(points_m.cols(), true));
}

RaysInCells SelectRays(const ScoredMap& map, const Contour& contour, const KnownRays& rays) {
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    if (rays[i]) chosen.push_back(i);
  }
  return ToCells(contour.points_m(Eigen::all, chosen), map.geometry(), contour.weights(chosen));
}

FitGain::FitGain(const ScoredMap& map, const Contour& contour, const DegenerateAxis& axis, const Pose2& from)
    : map_(map),
      contour_(contour),
      axis_(axis),
      from_(from),
      yaw_rad_(from.yaw_rad),
      rays_m_(Turn(contour.points_m, yaw_rad_)),
      known_from_(FindKnownOf(map.cells(), rays_m_, from, axis, 0.0, KnownRays::Constant(rays_m_.cols(), true))) {}

double FitGain::At(const Pose2& to) {
  if (to.yaw_rad != yaw_rad_) rays_m_ = Turn(contour_.points_m, yaw_rad_ = to.yaw_rad);
  asked_ = to;
  return Compare(to, FindKnownOf(map_.cells(), rays_m_, to, axis_, 0.0, known_from_));
}

double FitGain::Near(const Pose2& to, double as_known_within_m) {
  const bool as_known = asked_ && asked_->yaw_rad == to.yaw_rad && Distance(*asked_, to) <= as_known_within_m;
  return as_known ? share_ * (Fit(to) - fit_from_) : At(to);
}

double FitGain::Compare(const Pose2& to, KnownRays known_from_both) {
  if (!rays_ || (known_from_both != compared_).any()) {
    compared_ = std::move(known_from_both);
    rays_ = SelectRays(map_, contour_, compared_);
    share_ = static_cast<double>(rays_->total_weight()) / static_cast<double>(contour_.weights.sum());
    fit_from_ = Fit(from_);
  }
  return share_ * (Fit(to) - fit_from_);
}

}  // namespace crsm
