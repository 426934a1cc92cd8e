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

/// The map enlarged, for people, as PNG bytes. On the floor, and under the walls, so that it hides none: the path from
/// green to red, both ends of each loop joined by a line (of a rejected one by dashes), breaks as crosses, lost scans,
/// and the last scan's hits, deskewed. Over the walls the places with names. What is not explored, around the map too,
/// is grey blue. Below it are the verdict and its reasons, counts, a scale bar and a legend. At least one cell; all
/// poses finite.
std::string EncodeOverview(const Results& results, PngEncoder& encoder);
inline std::string EncodeOverview(const Results& results) {
  PngEncoder encoder(PngEncoder::Use::kOnce);
  return EncodeOverview(results, encoder);
}

}  // namespace crsm
