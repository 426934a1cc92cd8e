#pragma once

#include <string>

#include "common/logs/map_picture.hpp"
#include "common/logs/replacement.hpp"
#include "common/map/dense_grid.hpp"

namespace crsm {

/// The text of map.yaml, which names a picture beside it. At least one cell.
std::string FormatMapYaml(const DenseGrid& grid, const std::string& picture = kMapPicture);

/// The map of nothing: one unexplored cell, of 1 m if the size is 0.
DenseGrid MakeUnexploredCell(double cell_size_m);

/// The picture of EncodeMap in the plain form that some tools want, row by row. At least one cell.
void FormatPgm(const DenseGrid& grid, const Sink& sink);

}  // namespace crsm
