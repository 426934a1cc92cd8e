#include "common/match/fit/fitness_kernel.hpp"

#include <algorithm>
#include <cstdint>

namespace crsm {
namespace {

/// std::floor is a function call on the x86-64 that every machine has.
int FloorToInt(float value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
}

/// The pair of a cell of the rectangle. Beyond its end lies a tile that nothing is explored in.
const ScorePair* FindPair(const FitnessTask& task, unsigned x, unsigned y) {
  const unsigned tile = (y >> kTileBits) * (task.tiles.width + 1) + (x >> kTileBits);
  return task.pairs + tile * kPairsInTile + (y & kTileMask) * kPairsInRow + (x & kTileMask);
}

std::int64_t SumBilinear(const FitnessTask& task) {
  std::int64_t sum = 0;
  for (int i = 0; i < task.num_rays; ++i) {
    // Line 5 of section 5.2. As unsigned numbers, points left of or below the rectangle lie beyond its end.
    const int from_corner_x = FloorToInt(task.cos * task.x[i] - task.sin * task.y[i] + task.offset_x);
    const int from_corner_y = FloorToInt(task.sin * task.x[i] + task.cos * task.y[i] + task.offset_y);
    const unsigned x = std::min(static_cast<unsigned>(task.corner_x) + static_cast<unsigned>(from_corner_x),
                                task.tiles.width << kFineTileBits);
    const unsigned y = std::min(static_cast<unsigned>(task.corner_y) + static_cast<unsigned>(from_corner_y),
                                task.tiles.height << kFineTileBits);
    const ScorePair* pair = FindPair(task, x >> kFractionBits, y >> kFractionBits);
    const int right = static_cast<int>(x) & task.fraction_mask;
    const int up = static_cast<int>(y) & task.fraction_mask;
    const int left_column = pair[0].here * (kFractions - up) + pair[0].above * up;
    const int right_column = pair[1].here * (kFractions - up) + pair[1].above * up;
    const std::int64_t weight = task.weight ? task.weight[i] : 1;
    sum += weight * (left_column * (kFractions - right) + right_column * right);
  }
  return sum;
}

/// A quadratic B-spline between three values in a row, at the share `f` of the middle one's cell: its value and its
/// derivatives. It is the mean of what is linear between the values over a cell around the point.
struct Quadratic {
  Quadratic(float before, float here, float after, float f) {
    const float rise = here - before;
    bend = (after - here) - rise;
    slope = rise + f * bend;
    value = 0.5f * (before + here) + f * (rise + 0.5f * f * bend);
  }

  float value, slope, bend;
};

SplineSums SumSpline(const FitnessTask& task) {
  SplineLanes lanes = {};
  for (int i = 0; i < task.num_rays; ++i) {
    const float arm_x = task.cos * task.x[i] - task.sin * task.y[i];
    const float arm_y = task.sin * task.x[i] + task.cos * task.y[i];
    const float at_x = arm_x + task.offset_x;
    const float at_y = arm_y + task.offset_y;
    const int whole_x = FloorToInt(at_x);
    const int whole_y = FloorToInt(at_y);
    const float right = at_x - static_cast<float>(whole_x);
    const float up = at_y - static_cast<float>(whole_y);
    const unsigned x =
        std::min(static_cast<unsigned>(task.corner_x) + static_cast<unsigned>(whole_x), task.tiles.width << kTileBits);
    const unsigned y =
        std::min(static_cast<unsigned>(task.corner_y) + static_cast<unsigned>(whole_y), task.tiles.height << kTileBits);
    const ScorePair* low = FindPair(task, x, y);
    const ScorePair* high = low + kPairsInRow;
    const auto Column = [&](int j) { return Quadratic(low[j].here, low[j].above, high[j].above, up); };
    const Quadratic left = Column(0);
    const Quadratic middle = Column(1);
    const Quadratic next = Column(2);
    const Quadratic of_values(left.value, middle.value, next.value, right);
    const Quadratic of_slopes(left.slope, middle.slope, next.slope, right);
    const Quadratic of_bends(left.bend, middle.bend, next.bend, right);
    const float s_x = of_values.slope;
    const float s_y = of_slopes.value;
    const float s_xx = of_values.bend;
    const float s_xy = of_slopes.slope;
    const float s_yy = of_bends.value;
    const float x_yaw = s_xy * arm_x - s_xx * arm_y;
    const float y_yaw = s_yy * arm_x - s_xy * arm_y;
    const float weight = task.weight ? static_cast<float>(task.weight[i]) : 1.0f;
    const std::array<float, kSplineSums> of_ray = {of_values.value,
                                                   s_x,
                                                   s_y,
                                                   s_y * arm_x - s_x * arm_y,
                                                   s_xx,
                                                   s_xy,
                                                   s_yy,
                                                   x_yaw,
                                                   y_yaw,
                                                   (y_yaw * arm_x - x_yaw * arm_y) - (s_x * arm_x + s_y * arm_y)};
    const std::size_t lane = static_cast<std::size_t>(i) % kSplineLanes;
    for (std::size_t k = 0; k < kSplineSums; ++k) lanes[k][lane] += weight * of_ray[k];
  }
  return AddLanes(lanes);
}

}  // namespace

FitnessKernel PlainFitnessKernel() { return {SumBilinear, SumSpline}; }

std::vector<FitnessKernel> FindFitnessKernels() {
  std::vector<FitnessKernel> kernels{PlainFitnessKernel()};
  if (const auto avx2 = Avx2FitnessKernel()) kernels.push_back(*avx2);
  return kernels;
}

}  // namespace crsm
