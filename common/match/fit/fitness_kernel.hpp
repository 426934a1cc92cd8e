#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/map/tile_grid.hpp"

namespace crsm {

/// The largest score of one ray: it and its four neighbours on cells of value 0 (section 5.2, line 10).
inline constexpr int kFullScore = (10 + 4) * 255;

/// What a ray scores that ends in a cell, and in the one above it; counted from the score of unexplored cells, which is
/// -kFullScore to kFullScore.
struct ScorePair {
  std::int16_t here;
  std::int16_t above;
};

// The scores of one tile's cells, row by row, with two more columns and one more row of pairs than the tile has: the
// nine scores around any cell of the tile and the next ones to its right and above lie side by side.
inline constexpr int kPairsInRow = kTileSide + 2;
inline constexpr int kPairRows = kTileSide + 1;
inline constexpr int kPairsInTile = kPairsInRow * kPairRows;

inline constexpr int kFractionBits = 7;
inline constexpr int kFractions = 1 << kFractionBits;                 ///< a point is placed to 1/128 of a cell
inline constexpr unsigned kFineTileBits = kTileBits + kFractionBits;  ///< in 1/128 cell, shifted by these: its tile

/// Rays and the pose from which they are seen. Lengths are in cells, but for those in the unit of the kernel: a
/// fraction of a cell for `bilinear`, a cell for `spline`.
struct FitnessTask {
  const float* x;     ///< where the rays end, laser frame
  const float* y;     ///< at most 2^22 from the laser
  const int* weight;  ///< nullptr: all are 1
  int num_rays;

  float sin;  ///< of the laser's yaw, times units in a cell
  float cos;
  float offset_x;  ///< of the laser from the corner of its cell [unit]
  float offset_y;
  int corner_x;  ///< of that cell from the corner of the rectangle [unit]
  int corner_y;
  int fraction_mask;  ///< kFractions - 1: between cells; 0: the score of the cell alone. Of `bilinear`

  TileRectangle tiles;
  const ScorePair* pairs;  ///< tiles.num_places() x kPairsInTile
};

/// What the rays score by a quadratic B-spline, weighted, and its derivatives by the laser's place [cells] and yaw
/// [rad]: sums over the rays.
struct SplineSums {
  double value;
  double x, y, yaw;
  double xx, xy, yy, x_yaw, y_yaw, yaw_yaw;
};

/// Two ways to read the scores between cells. All kernels give the same sums: those of `bilinear` are of whole numbers
/// once the way to a cell is made of the same roundings in the same order; those of `spline` are of floats that are
/// added up in a fixed order.
struct FitnessKernel {
  /// Sum of what the rays score, weighted, times kFractions^2: between four scores, of which the task places the lower
  /// left one.
  std::int64_t (*bilinear)(const FitnessTask&);
  /// Between nine scores, of which it places the lower left one.
  SplineSums (*spline)(const FitnessTask&);
};

/// The one that defines what the others compute.
FitnessKernel PlainFitnessKernel();

/// The one for processors that have AVX2, where this one has.
std::optional<FitnessKernel> Avx2FitnessKernel();

/// Those that this processor can run, the fastest last.
std::vector<FitnessKernel> FindFitnessKernels();

// For those who write kernels: the i-th ray is added up in lane i % kSplineLanes, and the lanes at the end.
inline constexpr std::size_t kSplineSums = sizeof(SplineSums) / sizeof(double);
inline constexpr std::size_t kSplineLanes = 8;
using SplineLanes = std::array<std::array<float, kSplineLanes>, kSplineSums>;

inline SplineSums AddLanes(const SplineLanes& lanes) {
  std::array<double, kSplineSums> sums{};
  for (std::size_t i = 0; i < kSplineSums; ++i) {
    for (const float sum : lanes[i]) sums[i] += double{sum};
  }
  return {sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6], sums[7], sums[8], sums[9]};
}

}  // namespace crsm
