#include "common/fitness_field.hpp"

#include <algorithm>
#include <cmath>

namespace crsm {
namespace {

constexpr int kFractionBits = 7;  // a point is placed to 1/128 of a cell
constexpr int kFractions = 1 << kFractionBits;

/// std::floor is a function call on the x86-64 that every machine has.
int FloorToInt(float value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
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

FitnessField::FitnessField(double unexplored_score, bool interpolate)
    : unexplored_score_(static_cast<std::int16_t>(std::lround(unexplored_score))), interpolate_(interpolate) {
  unexplored_.score.fill(unexplored_score_);
}

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
  for (const TileIndex index : stale) RefreshTile(map, index);
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

  Tile& field = tiles_.Touch(index);
  for (int y = 0; y < kSide; ++y) {
    const std::uint8_t* row = bytes.data() + (y + 1) * kPadded + 1;
    for (int x = 0; x < kSide; ++x) {
      const std::uint8_t* cell = row + x;
      const int around = cell[-1] + cell[1] + cell[-kPadded] + cell[kPadded];
      field.score[static_cast<std::size_t>(y * kSide + x)] =
          *cell == kUnexploredByte ? unexplored_score_                                             // lines 6 to 9
                                   : static_cast<std::int16_t>(kFullScore - 10 * *cell - around);  // line 10
    }
  }
}

double FitnessField::Evaluate(const RaysInCells& rays, const Pose2& T_map_laser, const MapGeometry& geometry) const {
  if (rays.size() == 0) return 0.0;
  // Points are placed relative to the laser's cell, where single precision is exact to 1/128 of a cell.
  const double laser_x = geometry.ToCells(T_map_laser.x_m);
  const double laser_y = geometry.ToCells(T_map_laser.y_m);
  const Cell anchor{static_cast<int>(std::floor(laser_x)), static_cast<int>(std::floor(laser_y))};
  // Interpolation is between the centres of cells, which lie half a cell up and right of their corners.
  const double centre = interpolate_ ? 0.5 : 0.0;
  const auto offset_x = static_cast<float>(laser_x - anchor.x - centre);
  const auto offset_y = static_cast<float>(laser_y - anchor.y - centre);
  const auto rotation = ComputeSinCos(T_map_laser.yaw_rad);
  const auto sin = static_cast<float>(rotation.sin);
  const auto cos = static_cast<float>(rotation.cos);

  std::int64_t sum = 0;  // whole numbers: the order of the rays does not matter
  for (Eigen::Index i = 0; i < rays.size(); ++i) {
    const float x = cos * rays.x[i] - sin * rays.y[i] + offset_x;  // line 5
    const float y = sin * rays.x[i] + cos * rays.y[i] + offset_y;
    const int fixed_x = FloorToInt(x * kFractions);
    const int fixed_y = FloorToInt(y * kFractions);
    const Cell cell{anchor.x + (fixed_x >> kFractionBits), anchor.y + (fixed_y >> kFractionBits)};
    const Tile* tile = tiles_.Find(TileOf(cell));
    if (!tile) tile = &unexplored_;
    const std::int16_t* score = tile->score.data() + (cell.y & 63) * kSide + (cell.x & 63);
    if (!interpolate_) {
      sum += std::int64_t{rays.weight[i]} * *score * (kFractions * kFractions);
      continue;
    }
    const int right = fixed_x & (kFractions - 1);
    const int up = fixed_y & (kFractions - 1);
    const int low_row = score[0] * (kFractions - right) + score[1] * right;
    const int high_row = score[kSide] * (kFractions - right) + score[kSide + 1] * right;
    sum += std::int64_t{rays.weight[i]} * (low_row * (kFractions - up) + high_row * up);
  }
  constexpr double kFullSum = double{kFullScore} * kFractions * kFractions;
  return static_cast<double>(sum) / (kFullSum * rays.weight.sum());
}

}  // namespace crsm
