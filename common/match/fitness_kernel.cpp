#include "common/match/fitness_kernel.hpp"

#include <algorithm>
#include <cstdint>

namespace crsm {
namespace {

/// std::floor is a function call on the x86-64 that every machine has.
int FloorToInt(float value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
}

/// Sum of what the rays score, weighted. score: what one does, times kFractions^2, from the pair where its scores begin
/// and how far right of and above it the ray ends [1/128 cell].
template <class ScoreAt>
std::int64_t SumPlainly(const FitnessTask& task, ScoreAt&& score) {
  const TileRectangle& tiles = task.tiles;
  std::int64_t sum = 0;
  for (int i = 0; i < task.num_rays; ++i) {
    // Line 5 of section 5.2. As unsigned numbers, points left of or below the rectangle lie beyond its end.
    const int from_corner_x = FloorToInt(task.cos * task.x[i] - task.sin * task.y[i] + task.offset_x);
    const int from_corner_y = FloorToInt(task.sin * task.x[i] + task.cos * task.y[i] + task.offset_y);
    const unsigned x = std::min(static_cast<unsigned>(task.corner_x) + static_cast<unsigned>(from_corner_x),
                                tiles.width << kFineTileBits);
    const unsigned y = std::min(static_cast<unsigned>(task.corner_y) + static_cast<unsigned>(from_corner_y),
                                tiles.height << kFineTileBits);

    const ScorePair* tile =
        task.pairs + ((y >> kFineTileBits) * (tiles.width + 1) + (x >> kFineTileBits)) * kPairsInTile;
    const unsigned cell_x = (x >> kFractionBits) & kTileMask;
    const unsigned cell_y = (y >> kFractionBits) & kTileMask;
    const int right = static_cast<int>(x) & task.fraction_mask;
    const int up = static_cast<int>(y) & task.fraction_mask;
    const std::int64_t weight = task.weight ? task.weight[i] : 1;
    sum += weight * score(tile + cell_y * kPairsInRow + cell_x, right, up);
  }
  return sum;
}

std::int64_t SumBilinear(const FitnessTask& task) {
  return SumPlainly(task, [](const ScorePair* pair, int right, int up) {
    const int left_column = pair[0].here * (kFractions - up) + pair[0].above * up;
    const int right_column = pair[1].here * (kFractions - up) + pair[1].above * up;
    return left_column * (kFractions - right) + right_column * right;
  });
}

/// Without its last bits, rounded.
int RoundedShift(int value, int bits) { return (value + (1 << bits >> 1)) >> bits; }

/// The weights of three cells in a row, for a point in the middle one.
struct SplineWeights {
  explicit SplineWeights(int fraction)
      : before(Half((kFractions - fraction) * (kFractions - fraction))),
        after(Half(fraction * fraction)),
        here(kSplineUnit - before - after) {}

  static int Half(int square) { return RoundedShift(square, kSplineSquareShift); }

  int before, after, here;
};

std::int64_t SumSpline(const FitnessTask& task) {
  return SumPlainly(task, [](const ScorePair* pair, int right, int up) {
    const SplineWeights x(right);
    const SplineWeights y(up);
    const ScorePair* next_row = pair + kPairsInRow;
    const auto Column = [&](int i) {
      const int sum = pair[i].here * y.before + pair[i].above * y.here + next_row[i].above * y.after;
      return RoundedShift(sum, kSplineColumnShift);
    };
    return RoundedShift(Column(0) * x.before + Column(1) * x.here + Column(2) * x.after, kSplineSumShift);
  });
}

}  // namespace

FitnessKernel PlainFitnessKernel() { return {SumBilinear, SumSpline}; }

std::vector<FitnessKernel> FindFitnessKernels() {
  std::vector<FitnessKernel> kernels{PlainFitnessKernel()};
  if (const auto avx2 = Avx2FitnessKernel()) kernels.push_back(*avx2);
  return kernels;
}

}  // namespace crsm
