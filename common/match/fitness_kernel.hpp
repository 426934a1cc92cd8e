#pragma once

#include <cstdint>
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

// The scores of one tile's cells, row by row. Each row has one more pair than the tile has columns: the four scores
// around any point of the tile lie side by side, in a pair and the next.
inline constexpr int kPairsInRow = kTileSide + 1;
inline constexpr int kPairsInTile = kPairsInRow * kTileSide;

inline constexpr int kFractionBits = 7;
inline constexpr int kFractions = 1 << kFractionBits;  ///< a point is placed to 1/128 of a cell

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
///
/// All kernels give the same sum: the way to a cell is made of the same roundings in the same order, and what follows
/// is whole numbers.
using FitnessKernel = std::int64_t (*)(const FitnessTask&);

/// The one that defines what the others compute.
std::int64_t SumScores(const FitnessTask& task);

/// Those that this processor can run, the fastest last.
std::vector<FitnessKernel> FindFitnessKernels();

}  // namespace crsm
