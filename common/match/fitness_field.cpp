#include "common/match/fitness_field.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <utility>

namespace crsm {
namespace {

/// A coordinate split into its cell and the rest, which is in [0, 1).
struct SplitCoordinate {
  int cell;
  double rest;
};

/// What lies far beyond the limits of the map is brought nearer, where all is as unexplored, so that no sum overflows.
SplitCoordinate Split(double cells) {
  constexpr double kFar = 8.0 * kMaxCell;
  const double near = std::clamp(cells, -kFar, kFar);
  const int truncated = static_cast<int>(near);
  const int cell = truncated - (near < truncated ? 1 : 0);  // std::floor is a function call on old processors
  return {cell, near - cell};
}

/// All 0. The system gives memory only to those that are written to.
ScorePair* MakeBlankTiles(const TileRectangle& rectangle) {
  void* pairs = std::calloc(rectangle.num_places(), kPairsInTile * sizeof(ScorePair));
  if (!pairs) throw std::bad_alloc();
  return static_cast<ScorePair*>(pairs);
}

/// Tiles with scores that depend on the given ones. A cell's score depends on its neighbours, and a tile holds the
/// first row and column of the next: a change reaches the tiles around it, but those that hold no cell of the map.
std::vector<TileIndex> FindStale(const ByteMap& map, const std::vector<TileIndex>& changed) {
  const auto InMap = [&](TileIndex index) { return map.tiles().Find(index) != nullptr; };
  std::vector<TileIndex> stale;
  for (const TileIndex index : changed) {
    for (int y = index.y - 1; y <= index.y + 1; ++y) {
      for (int x = index.x - 1; x <= index.x + 1; ++x) {
        if (InMap({x, y}) || InMap({x + 1, y}) || InMap({x, y + 1}) || InMap({x + 1, y + 1})) stale.push_back({x, y});
      }
    }
  }
  std::sort(stale.begin(), stale.end());
  stale.erase(std::unique(stale.begin(), stale.end()), stale.end());
  return stale;
}

}  // namespace

RaysInCells::RaysInCells(Eigen::ArrayXf x, Eigen::ArrayXf y, Eigen::ArrayXi weight)
    : x_(std::move(x)),
      y_(std::move(y)),
      weight_(std::move(weight)),
      total_weight_(weight_.cast<std::int64_t>().sum()) {}

RaysInCells ToCells(const Eigen::Matrix2Xd& hits_m, const MapGeometry& geometry, const Eigen::ArrayXi& weight) {
  const Eigen::Matrix2Xf hits = (hits_m / geometry.cell_size_m()).cast<float>();
  return {hits.row(0).transpose(), hits.row(1).transpose(), weight};
}

RaysInCells ToCells(const Eigen::Matrix2Xd& hits_m, const MapGeometry& geometry) {
  return ToCells(hits_m, geometry, Eigen::ArrayXi::Ones(hits_m.cols()));
}

Eigen::ArrayXi ComputeWeights(const ValidRays& rays, double cap_m) {
  constexpr double kSteps = 20.0;
  Eigen::ArrayXi weights = Eigen::ArrayXi::Ones(static_cast<Eigen::Index>(rays.size()));
  if (cap_m <= 0.0) return weights;
  const std::vector<double> displacements = ComputeDisplacements(rays);
  const auto Capped = [&](Eigen::Index i) {
    const bool inside = i >= 0 && i < static_cast<Eigen::Index>(displacements.size());
    return inside ? std::min(displacements[static_cast<std::size_t>(i)], cap_m) / cap_m : 0.0;
  };
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    weights[i] += static_cast<int>(0.5 * kSteps * (Capped(i - 1) + Capped(i)));
  }
  return weights;
}

FitnessField::FitnessField(double unexplored_score, bool interpolate, FitnessKernel kernel)
    : unexplored_score_(static_cast<std::int16_t>(std::lround(unexplored_score))),
      interpolate_(interpolate),
      kernel_(kernel),
      pairs_(MakeBlankTiles(rectangle_)) {}

void FitnessField::Refresh(const ByteMap& map, const std::vector<TileIndex>& changed) {
  std::vector<TileIndex> stale = FindStale(map, changed);
  TileRectangle grown = rectangle_;
  for (const TileIndex index : stale) {
    if (!grown.Contains(index)) grown = grown.GrownTo(index);
  }
  if (grown.num_places() != rectangle_.num_places()) {  // all tiles move: each is made anew
    pairs_.reset(MakeBlankTiles(grown));
    rectangle_ = grown;
    std::vector<TileIndex> all;
    for (const auto& entry : map.tiles().entries()) all.push_back(entry.index);
    stale = FindStale(map, all);
  }
  for (const TileIndex index : stale) RefreshTile(map, index);
}

void FitnessField::RefreshTile(const ByteMap& map, TileIndex index) {
  // The tile's bytes with one column and row before it and two after it.
  constexpr int kPadded = kTileSide + 3;
  std::array<std::uint8_t, kPadded * kPadded> bytes;
  bytes.fill(kUnexploredByte);
  for (int tile_y = -1; tile_y <= 1; ++tile_y) {
    for (int tile_x = -1; tile_x <= 1; ++tile_x) {
      const ByteMap::Tile* part = map.tiles().Find({index.x + tile_x, index.y + tile_y});
      if (!part) continue;
      const int x_low = std::max(-1, tile_x * kTileSide);
      const int x_high = std::min(kTileSide + 2, (tile_x + 1) * kTileSide);
      const int y_low = std::max(-1, tile_y * kTileSide);
      const int y_high = std::min(kTileSide + 2, (tile_y + 1) * kTileSide);
      for (int y = y_low; y < y_high; ++y) {
        const auto* row = part->cells.data() + (y & kTileMask) * kTileSide;
        std::copy(row + (x_low & kTileMask), row + (x_low & kTileMask) + (x_high - x_low),
                  bytes.data() + (y + 1) * kPadded + x_low + 1);
      }
    }
  }

  // Each score goes into two pairs: its own and, as the one above, that of the row below.
  ScorePair* tile = pairs_.get() + rectangle_.Place(index) * kPairsInTile;
  for (int y = 0; y <= kTileSide; ++y) {
    const std::uint8_t* row = bytes.data() + (y + 1) * kPadded + 1;
    for (int x = 0; x <= kTileSide; ++x) {
      const std::uint8_t* cell = row + x;
      const int around = cell[-1] + cell[1] + cell[-kPadded] + cell[kPadded];
      const int score = *cell == kUnexploredByte ? unexplored_score_                  // lines 6 to 9
                                                 : kFullScore - 10 * *cell - around;  // line 10
      const auto more = static_cast<std::int16_t>(score - unexplored_score_);
      ScorePair* pair = tile + y * kPairsInRow + x;
      if (y < kTileSide) pair->here = more;
      if (y > 0) (pair - kPairsInRow)->above = more;
    }
  }
}

double FitnessField::Evaluate(const RaysInCells& rays, const Pose2& T_map_laser, const MapGeometry& geometry) const {
  if (rays.size() == 0) return 0.0;
  // Points are placed relative to the laser's cell, where single precision is exact to 1/128 of a cell.
  const SplitCoordinate laser_x = Split(geometry.ToCells(T_map_laser.x_m));
  const SplitCoordinate laser_y = Split(geometry.ToCells(T_map_laser.y_m));
  // Interpolation is between the centres of cells, which lie half a cell up and right of their corners. It begins at
  // the nearest 1/128 of a cell, where kernels round down: a bias of each match, however small, adds up from scan to
  // scan.
  const double shift = interpolate_ ? 0.5 / kFractions - 0.5 : 0.0;
  const SinCos rotation = ComputeSinCos(T_map_laser.yaw_rad);

  FitnessTask task;
  task.x = rays.x().data();
  task.y = rays.y().data();
  task.weight = rays.weight().data();
  task.num_rays = static_cast<int>(rays.size());
  task.sin = static_cast<float>(rotation.sin) * kFractions;
  task.cos = static_cast<float>(rotation.cos) * kFractions;
  task.offset_x = static_cast<float>(laser_x.rest + shift) * kFractions;
  task.offset_y = static_cast<float>(laser_y.rest + shift) * kFractions;
  task.corner_x = (laser_x.cell - rectangle_.origin.x * kTileSide) * kFractions;
  task.corner_y = (laser_y.cell - rectangle_.origin.y * kTileSide) * kFractions;
  task.fraction_mask = interpolate_ ? kFractions - 1 : 0;
  task.tiles = rectangle_;
  task.pairs = pairs_.get();

  constexpr std::int64_t kUnit = kFractions * kFractions;
  const std::int64_t unexplored_sum = unexplored_score_ * kUnit * rays.total_weight();
  return static_cast<double>(kernel_(task) + unexplored_sum) /
         static_cast<double>(kFullScore * kUnit * rays.total_weight());
}

}  // namespace crsm
