#include "common/match/fit/pose_uncertainty.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "common/math/symmetric.hpp"

namespace crsm {
namespace {

/// Whether a chord is too short to tell a direction. Most are by far, which shows without a square root.
bool IsShort(const Eigen::Vector2d& chord_m, double least_m) {
  const double squared_m2 = chord_m.squaredNorm();
  return squared_m2 < 0.9 * least_m * least_m || std::sqrt(squared_m2) < least_m;
}

bool IsOnWall(const ByteMap& map, Cell cell) {
  const int x = cell.x & kTileMask;
  const int y = cell.y & kTileMask;
  if (x > 0 && x < kTileMask && y > 0 && y < kTileMask) {  // all in one tile
    const ByteMap::Tile* tile = map.tiles().Find(TileOf(cell));
    if (!tile) return false;
    const std::uint8_t* at = tile->cells.data() + OffsetInTile(cell);
    return IsOccupied(at[0]) || IsOccupied(at[-1]) || IsOccupied(at[1]) || IsOccupied(at[-kTileSide]) ||
           IsOccupied(at[kTileSide]);
  }
  const auto Occupied = [&](int dx, int dy) { return IsOccupied(map.At({cell.x + dx, cell.y + dy})); };
  return Occupied(0, 0) || Occupied(-1, 0) || Occupied(1, 0) || Occupied(0, -1) || Occupied(0, 1);
}

/// Whether what stands at a cell stands alone: nothing else does at `reach_cells` from it, where most is known to be
/// free. The end of a drawn wall has the unknown behind it.
bool IsPost(const ByteMap& map, Cell cell, int reach_cells, double free_share) {
  int num_free = 0;
  for (int i = -reach_cells; i < reach_cells; ++i) {
    const Cell side[] = {{cell.x + i, cell.y - reach_cells},
                         {cell.x + reach_cells, cell.y + i},
                         {cell.x - i, cell.y + reach_cells},
                         {cell.x - reach_cells, cell.y - i}};
    for (const Cell& at : side) {
      const std::uint8_t byte = map.At(at);
      if (IsOccupied(byte)) return false;
      num_free += byte != kUnexploredByte;
    }
  }
  return num_free >= free_share * 8 * reach_cells;
}

}  // namespace

Eigen::Matrix2Xd ComputeNormals(const Eigen::Matrix2Xd& hits_m, const Gaps& gaps, double cell_size_m,
                                const MatchConstants::Uncertainty& constants) {
  const std::vector<bool> joined =
      gaps.FindSurfaces(constants.near_cells * cell_size_m, constants.largest_surface_gap_m);
  const auto num = static_cast<int>(hits_m.cols());
  Eigen::Matrix2Xd normals = Eigen::Matrix2Xd::Zero(2, num);
  for (int i = 0; i < num; ++i) {
    int first = i;
    int last = i;
    Eigen::Vector2d chord = Eigen::Vector2d::Zero();
    for (bool grows = true; grows && IsShort(chord, constants.chord_m);) {
      grows = false;
      if (first > 0 && joined[static_cast<std::size_t>(first) - 1]) --first, grows = true;
      if (last + 1 < num && joined[static_cast<std::size_t>(last)]) ++last, grows = true;
      chord = hits_m.col(last) - hits_m.col(first);
    }
    if (last - first < constants.chord_gaps_min || IsShort(chord, constants.chord_m)) continue;
    normals.col(i) = Eigen::Vector2d(-chord.y(), chord.x()).normalized();
  }
  return normals;
}

PoseUncertainty ComputeUncertainty(const Eigen::Matrix2Xd& hits_m, const Eigen::Matrix2Xd& normals,
                                   const Pose2& T_map_laser, const ByteMap& map,
                                   const MatchConstants::Uncertainty& constants) {
  const MapGeometry& geometry = map.geometry();
  const auto [sin, cos] = ComputeSinCos(T_map_laser.yaw_rad);
  Eigen::Matrix2d rotation;
  rotation << cos, -sin, sin, cos;
  const Eigen::Matrix2Xd normals_map = rotation * normals;
  const Eigen::Matrix2Xd arms_m = rotation * hits_m;

  const int post_cells = static_cast<int>(std::ceil(geometry.ToCells(constants.chord_m)));
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < hits_m.cols(); ++i) {
    const auto n = normals_map.col(i);
    const auto p = arms_m.col(i);
    const Cell cell = geometry.CellAt(T_map_laser.x_m + p.x(), T_map_laser.y_m + p.y());
    if (!IsOnWall(map, cell)) continue;
    const auto Tell = [&](double x, double y) {
      const Eigen::Vector3d row(x, y, p.x() * y - p.y() * x);
      information += row.lazyProduct(row.transpose());  // without a temporary matrix
    };
    if (!n.isZero()) {
      Tell(n.x(), n.y());
    } else if (IsPost(map, cell, post_cells, constants.post_free_share)) {
      Tell(1.0, 0.0);
      Tell(0.0, 1.0);
    }
  }

  // In units of one ray: what is told of the position when the yaw is not known either.
  const double yaw_information = std::max(information(2, 2), 1e-9);
  const Eigen::Vector2d coupling = information.topRightCorner<2, 1>();
  const Eigen::Matrix2d position =
      information.topLeftCorner<2, 2>() - coupling * coupling.transpose() / yaw_information;
  const auto [weakest, axis] = FindWeakest(position);
  PoseUncertainty uncertainty;
  uncertainty.degenerate_axis = axis;
  uncertainty.degeneracy =
      (constants.few_rays + constants.noise_share * (position.trace() - weakest)) / std::max(weakest, 1e-9);

  const double sigma_m = constants.sigma_cells * geometry.cell_size_m();
  Eigen::Matrix3d prior = Eigen::Matrix3d::Zero();
  const double of_place = 1.0 / (constants.unknown_m * constants.unknown_m);
  prior.diagonal() << of_place, of_place, 1.0 / (constants.unknown_rad * constants.unknown_rad);
  uncertainty.covariance = (information / (sigma_m * sigma_m) + prior).inverse();
  uncertainty.covariance.diagonal() +=
      Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, constants.map_rad * constants.map_rad);
  return uncertainty;
}

}  // namespace crsm
