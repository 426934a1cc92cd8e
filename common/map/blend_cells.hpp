#pragma once

#include <cstdint>
#include <vector>

namespace crsm {

// Marks of the cells that a scan touches: 0 not at all, 1 free, or from there on occupied by this share.
inline constexpr std::uint8_t kFreeMark = 1;
inline constexpr std::uint8_t kOccupiedMark = 255;

/// How far a scan moves the cells that it touches, each a share of the way to free or occupied: 0 to 1.
struct BlendIntensity {
  float free;
  float occupied;
  float first;  ///< at least, of a cell that no scan has touched before
};

/// The asymptotic rule of section 6 on every marked cell of a tile; the marks are cleared. A cell that an obstacle
/// fills in part goes towards that part, by an intensity between that of a free cell and that of an occupied one.
///
/// A cell seen for the first time is believed nearly at once. What was just explored would else score better than what
/// is known to be free, and walls seen once worse than those seen often: each scan would fit best a little behind its
/// place, where the last ones ended, and a long drive come out too short.
///
/// marks, p_free, bytes: kTileCells each; bytes are p_free as the wire carries it. All kernels give the same.
using BlendKernel = void (*)(const BlendIntensity& intensity, std::uint8_t* marks, float* p_free, std::uint8_t* bytes);

/// Those that this processor can run, the fastest last.
std::vector<BlendKernel> FindBlendKernels();

}  // namespace crsm
