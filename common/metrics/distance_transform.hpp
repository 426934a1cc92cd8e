#pragma once

#include <vector>

#include "common/map/dense_grid.hpp"

namespace crsm {

/// The squared distance from the centre of each cell to that of the nearest obstacle [px2], in the order of the cells;
/// the largest float everywhere if there is no obstacle. Exact.
/// Source: Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8, 2012.
std::vector<float> ComputeSquaredDistances(const DenseGrid& grid);

}  // namespace crsm
