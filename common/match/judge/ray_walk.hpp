#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/map/byte_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/pose2.hpp"

namespace crsm {

/// Reads cells of a map, one beside the other as a rule: the tile that holds the last one is looked up once.
class CellReader {
 public:
  explicit CellReader(const ByteMap& map) : tiles_(map.tiles()), tile_(tiles_.Find(index_)) {}

  std::uint8_t At(Cell cell) {
    if (const TileIndex index = TileOf(cell); index != index_) {
      index_ = index;
      tile_ = tiles_.Find(index);
    }
    return tile_ ? tile_->cells[static_cast<std::size_t>(OffsetInTile(cell))] : kUnexploredByte;
  }

 private:
  const TileGrid<ByteMap::Tile>& tiles_;
  TileIndex index_;
  const ByteMap::Tile* tile_;
};

/// Whether something stands in the way of a ray: some cells of it at least, from first_m to last_m along it.
/// direction: unit vector, map frame. stands: of a cell's byte. False for what lies beyond the limits of the map.
template <class Stands>
bool IsInTheWay(const ByteMap& map, const Pose2& laser, const Eigen::Vector2d& direction, double first_m, double last_m,
                Stands&& stands, const MatchConstants::RayWalk& constants = {}) {
  constexpr int kStepBits = 32;  // coordinates are whole numbers of 2^-32 cells: a step is two additions
  constexpr double kOne = static_cast<double>(std::int64_t{1} << kStepBits);
  if (!(first_m < last_m)) return false;
  const MapGeometry& geometry = map.geometry();
  const double step_m = std::max(geometry.cell_size_m(), last_m / constants.most_steps);
  const Eigen::Vector2d from_m = Eigen::Vector2d(laser.x_m, laser.y_m) + first_m * direction;
  const Eigen::Vector2d to_m = Eigen::Vector2d(laser.x_m, laser.y_m) + last_m * direction;
  if (!geometry.InLimits(from_m.x(), from_m.y(), 0.0) || !geometry.InLimits(to_m.x(), to_m.y(), 0.0)) return false;
  const auto Fixed = [&](double length_m) { return static_cast<std::int64_t>(geometry.ToCells(length_m) * kOne); };
  const std::int64_t dx = Fixed(step_m * direction.x());
  const std::int64_t dy = Fixed(step_m * direction.y());
  std::int64_t x = Fixed(from_m.x());
  std::int64_t y = Fixed(from_m.y());
  CellReader cells(map);
  int num = 0;
  for (auto steps = static_cast<int>(std::ceil((last_m - first_m) / step_m)); steps > 0; --steps, x += dx, y += dy) {
    const Cell cell{static_cast<int>(x >> kStepBits), static_cast<int>(y >> kStepBits)};
    if (stands(cells.At(cell)) && ++num >= constants.least_cells) return true;
  }
  return false;
}

}  // namespace crsm
