#pragma once

#include <string>

#include "common/map/dense_grid.hpp"
#include "common/results/png.hpp"
#include "common/results/results.hpp"

namespace crsm {

/// A grid as PNG bytes: 8-bit grey, a pixel a cell, top row = highest y. At least one cell. encoder: of such pictures
/// of this map alone.
std::string EncodeMap(const DenseGrid& grid, PngEncoder& encoder);
inline std::string EncodeMap(const DenseGrid& grid) {
  PngEncoder encoder(PngEncoder::Use::kOnce);
  return EncodeMap(grid, encoder);
}

/// The map enlarged, with the trajectory from green to red, loops as lines between two discs, turquoise where they are
/// closed, violet where one joined two pieces, and brown where they were rejected, breaks as crimson crosses, lost
/// scans orange, the last scan's hits magenta, deskewed, and below it a strip with a scale bar, the number of scans and
/// the meaning of the colours, as PNG bytes. At least one cell; all poses finite.
std::string EncodeOverview(const Results& results, PngEncoder& encoder);
inline std::string EncodeOverview(const Results& results) {
  PngEncoder encoder(PngEncoder::Use::kOnce);
  return EncodeOverview(results, encoder);
}

}  // namespace crsm
