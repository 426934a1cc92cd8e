#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crsm {

inline constexpr std::uint8_t kFreeByte = 255;
inline constexpr std::uint8_t kUnexploredByte = 127;  ///< and of no explored cell
inline constexpr std::uint8_t kOccupiedByte = 0;

inline bool IsFree(std::uint8_t byte) { return byte > kUnexploredByte; }
inline bool IsOccupied(std::uint8_t byte) { return byte < kUnexploredByte; }

/// The explored part of a map as one rectangle, for pictures and metrics.
struct DenseGrid {
  int width_cells = 0;
  int height_cells = 0;
  int origin_x_cells = 0;  ///< of the lower left cell; the map's origin is the lower left corner of cell (0, 0)
  int origin_y_cells = 0;
  double cell_size_m = 0.0;
  std::vector<std::uint8_t> cells;  ///< row by row from the lower left, y up: 255 free .. 0 occupied, 127 unexplored

  std::size_t IndexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width_cells) + static_cast<std::size_t>(column);
  }
};

}  // namespace crsm
