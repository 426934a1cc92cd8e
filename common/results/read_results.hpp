#pragma once

#include <filesystem>

#include "common/map/dense_grid.hpp"

namespace crsm {

/// The map that WriteResults left in `dir`: map.png with its cell size and origin from map.yaml.
/// Throws std::runtime_error that names the file and what is wrong with it.
DenseGrid ReadMap(const std::filesystem::path& dir);

/// The mean fitness that its summary.json tells (the paper's MFV). Throws std::runtime_error as ReadMap.
double ReadMeanFitness(const std::filesystem::path& dir);

}  // namespace crsm
