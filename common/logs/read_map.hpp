#pragma once

#include <filesystem>

#include "common/map/byte_map.hpp"
#include "common/map/dense_grid.hpp"

namespace crsm {

/// The map in the results of a run, from `dir`'s map.png and map.yaml: a cell a pixel. Throws std::runtime_error that
/// names the file if one of them is missing or is something else.
DenseGrid ReadMap(const std::filesystem::path& dir);

/// The same as tiles. Throws std::runtime_error also if it is larger than a map can be.
ByteMap ReadByteMap(const std::filesystem::path& dir);

}  // namespace crsm
