#include "common/map/blend_cells.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "common/map/dense_grid.hpp"
#include "common/map/tile_grid.hpp"

namespace crsm {
namespace {

#define CRSM_INLINE __attribute__((always_inline)) inline

/// The value, or 0, without a branch: loops over cells in which no way parts are compiled to compute several at a time.
CRSM_INLINE int If(bool condition, int value) { return value & -static_cast<int>(condition); }

/// One byte of the wire for the probability of being free; 127 is kept for unexplored cells.
CRSM_INLINE int ToByte(float p_free) {
  const int byte = static_cast<int>(p_free * 255.0f + 0.5f);
  return byte + If(byte == kUnexploredByte, 1 - 2 * static_cast<int>(p_free < 0.5f));
}

CRSM_INLINE void BlendCells(const BlendIntensity& intensity, std::uint8_t* marks, float* p_free, std::uint8_t* bytes) {
  constexpr std::size_t kAtOnce = 32;  // cells
  const auto [free, occupied, first] = intensity;
  for (std::size_t begin = 0; begin < kTileCells;
       begin += kAtOnce, marks += kAtOnce, p_free += kAtOnce, bytes += kAtOnce) {
    constexpr std::array<std::uint8_t, kAtOnce> kNone{};
    if (std::memcmp(marks, kNone.data(), kAtOnce) == 0) continue;
    for (std::size_t i = 0; i < kAtOnce; ++i) {
      const int mark = marks[i];
      const int byte = bytes[i];
      const float c = p_free[i];
      const float share = static_cast<float>(If(mark != kFreeMark, mark)) / kOccupiedMark;  // of an obstacle
      const float least = first * static_cast<float>(If(byte == kUnexploredByte, 1));
      const float wanted = free + (occupied - free) * share;
      const float update = (wanted < least ? least : wanted) * static_cast<float>(If(mark != 0, 1));
      p_free[i] = c + (1.0f - share - c) * update;
      bytes[i] = static_cast<std::uint8_t>(byte + If(mark != 0, ToByte(p_free[i]) - byte));
    }
    std::fill_n(marks, kAtOnce, std::uint8_t{0});
  }
}

void BlendOnAny(const BlendIntensity& intensity, std::uint8_t* marks, float* p_free, std::uint8_t* bytes) {
  BlendCells(intensity, marks, p_free, bytes);
}

#ifdef __x86_64__
/// The same, compiled for twice as many at a time.
__attribute__((target("avx2"))) void BlendAvx2(const BlendIntensity& intensity, std::uint8_t* marks, float* p_free,
                                               std::uint8_t* bytes) {
  BlendCells(intensity, marks, p_free, bytes);
}
#endif

}  // namespace

std::vector<BlendKernel> FindBlendKernels() {
  std::vector<BlendKernel> kernels{BlendOnAny};
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) kernels.push_back(BlendAvx2);
#endif
  return kernels;
}

}  // namespace crsm
