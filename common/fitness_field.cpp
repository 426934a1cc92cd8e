#include "common/fitness_field.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

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

std::unique_ptr<FitnessTile> MakeTile(std::int16_t score) {
  auto tile = std::make_unique<FitnessTile>();
  tile->pairs.fill({score, score});
  return tile;
}

}  // namespace

RaysInCells ToCells(const Eigen::Matrix2Xd& hits_m, const MapGeometry& geometry) {
  const Eigen::Matrix2Xf hits = (hits_m / geometry.cell_size_m()).cast<float>();
  return {hits.row(0).transpose(), hits.row(1).transpose(), Eigen::ArrayXi::Ones(hits.cols())};
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
      tiles_(MakeTile(unexplored_score_)) {}

void FitnessField::Refresh(const ByteMap& map, const std::vector<TileIndex>& changed) {
  // A cell's score depends on its neighbours, and a tile holds the first row and column of the next: a change reaches
  // the tiles around it.
  std::vector<TileIndex> stale;
  for (const TileIndex index : changed) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (InMapLimits(TileIndex{index.x + x, index.y + y})) stale.push_back({index.x + x, index.y + y});
      }
    }
  }
  std::sort(stale.begin(), stale.end());
  stale.erase(std::unique(stale.begin(), stale.end()), stale.end());
  const auto InMap = [&](TileIndex index) { return map.tiles().Find(index) != nullptr; };
  for (const TileIndex index : stale) {
    // Its scores are those of its own cells and of the first ones of the next tiles.
    const bool explored = InMap(index) || InMap({index.x + 1, index.y}) || InMap({index.x, index.y + 1}) ||
                          InMap({index.x + 1, index.y + 1});
    if (explored) RefreshTile(map, index);
  }
}

void FitnessField::RefreshTile(const ByteMap& map, TileIndex index) {
  // The tile's bytes with one column and row before it and two after it.
  constexpr int kPadded = kTileSide + 3;
  std::array<std::uint8_t, kPadded * kPadded> bytes;
  bytes.fill(kUnexploredByte);
  for (int tile_y = -1; tile_y <= 1; ++tile_y) {
    for (int tile_x = -1; tile_x <= 1; ++tile_x) {
      const ByteMap::Tile* tile = map.tiles().Find({index.x + tile_x, index.y + tile_y});
      if (!tile) continue;
      const int x_low = std::max(-1, tile_x * kTileSide);
      const int x_high = std::min(kTileSide + 2, (tile_x + 1) * kTileSide);
      const int y_low = std::max(-1, tile_y * kTileSide);
      const int y_high = std::min(kTileSide + 2, (tile_y + 1) * kTileSide);
      for (int y = y_low; y < y_high; ++y) {
        const auto* row = tile->cells.data() + (y & 63) * kTileSide;
        std::copy(row + (x_low & 63), row + (x_low & 63) + (x_high - x_low),
                  bytes.data() + (y + 1) * kPadded + x_low + 1);
      }
    }
  }

  // Each score goes into two pairs: its own and, as the one above, that of the row below.
  FitnessTile& field = tiles_.Touch(index);
  for (int y = 0; y <= kTileSide; ++y) {
    const std::uint8_t* row = bytes.data() + (y + 1) * kPadded + 1;
    for (int x = 0; x <= kTileSide; ++x) {
      const std::uint8_t* cell = row + x;
      const int around = cell[-1] + cell[1] + cell[-kPadded] + cell[kPadded];
      const std::int16_t score = *cell == kUnexploredByte
                                     ? unexplored_score_                                             // lines 6 to 9
                                     : static_cast<std::int16_t>(kFullScore - 10 * *cell - around);  // line 10
      const auto pair = static_cast<std::size_t>(y * FitnessTile::kPairsInRow + x);
      if (y < kTileSide) field.pairs[pair].here = score;
      if (y > 0) field.pairs[pair - FitnessTile::kPairsInRow].above = score;
    }
  }
}

double FitnessField::Evaluate(const RaysInCells& rays, const Pose2& T_map_laser, const MapGeometry& geometry) const {
  if (rays.size() == 0) return 0.0;
  // Points are placed relative to the laser's cell, where single precision is exact to 1/128 of a cell.
  const SplitCoordinate laser_x = Split(geometry.ToCells(T_map_laser.x_m));
  const SplitCoordinate laser_y = Split(geometry.ToCells(T_map_laser.y_m));
  // Interpolation is between the centres of cells, which lie half a cell up and right of their corners.
  const double centre = interpolate_ ? 0.5 : 0.0;
  const SinCos rotation = ComputeSinCos(T_map_laser.yaw_rad);

  FitnessTask task;
  task.x = rays.x.data();
  task.y = rays.y.data();
  task.weight = rays.weight.data();
  task.num_rays = static_cast<int>(rays.size());
  task.sin = static_cast<float>(rotation.sin) * kFractions;
  task.cos = static_cast<float>(rotation.cos) * kFractions;
  task.offset_x = static_cast<float>(laser_x.rest - centre) * kFractions;
  task.offset_y = static_cast<float>(laser_y.rest - centre) * kFractions;
  task.directory = tiles_.directory();
  task.corner_x = (laser_x.cell - task.directory.origin.x * kTileSide) * kFractions;
  task.corner_y = (laser_y.cell - task.directory.origin.y * kTileSide) * kFractions;
  task.fraction_mask = interpolate_ ? kFractions - 1 : 0;
  const std::int64_t sum = kernel_(task);

  constexpr double kFullSum = double{kFullScore} * kFractions * kFractions;
  return static_cast<double>(sum) / (kFullSum * rays.weight.sum());
}

}  // namespace crsm
