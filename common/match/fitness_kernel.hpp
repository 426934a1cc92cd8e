#pragma once

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

/// Rays and the pose from which they are seen. Lengths are in cells, but for those in fractions of a cell.
struct FitnessTask {
  const float* x;     ///< where the rays end, laser frame
  const float* y;     ///< at most 2^22 from the laser
  const int* weight;  ///< nullptr: all are 1
  int num_rays;

  float sin;  ///< of the laser's yaw, times kFractions
  float cos;
  float offset_x;  ///< of the laser from the corner of its cell [1/128 cell]
  float offset_y;
  int corner_x;  ///< of that cell from the corner of the rectangle [1/128 cell]
  int corner_y;
  int fraction_mask;  ///< kFractions - 1: between cells; 0: the score of the cell alone

  TileRectangle tiles;
  const ScorePair* pairs;  ///< tiles.num_places() x kPairsInTile
};

/// Sum of what the rays score, weighted, times kFractions^2.
using SumOfScores = std::int64_t (*)(const FitnessTask&);

/// Two ways to read the scores between cells. All kernels give the same sums: the way to a cell is made of the same
/// roundings in the same order, and what follows is whole numbers.
struct FitnessKernel {
  SumOfScores bilinear;  ///< between four scores, of which the task places the lower left one
  SumOfScores spline;    ///< a quadratic B-spline of nine scores, of which it places the lower left one
};

/// The one that defines what the others compute.
FitnessKernel PlainFitnessKernel();

/// The one for processors that have AVX2, where this one has.
std::optional<FitnessKernel> Avx2FitnessKernel();

/// Those that this processor can run, the fastest last.
std::vector<FitnessKernel> FindFitnessKernels();

// A quadratic B-spline is the mean of the bilinear one over a cell around the point. A point that lies the share f of a
// cell right of the border of its cell weighs the columns of the cells left, here and right of it by (1 - f)^2 / 2, the
// rest, and f^2 / 2, and their rows likewise.
inline constexpr int kSplineBits = 12;  ///< weights are in 1/4096
inline constexpr int kSplineUnit = 1 << kSplineBits;

// By how many bits numbers are shortened on the way: half a square in 1/128^2 to a weight, the sum of a column, so that
// 32 bits hold that of three weighted ones, and the latter to kFractions^2.
inline constexpr int kSplineSquareShift = 2 * kFractionBits + 1 - kSplineBits;
inline constexpr int kSplineColumnShift = 6;
inline constexpr int kSplineSumShift = 2 * kSplineBits - kSplineColumnShift - 2 * kFractionBits;

}  // namespace crsm
