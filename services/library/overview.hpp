#pragma once

#include <functional>
#include <string>

#include "common/results/results.hpp"

namespace crsm_slam {

/// What draws overview.png. Empty in the library, which has nothing to draw with; the Python module has its own.
std::function<std::string(const crsm::Results&)> OverviewEncoder();

}  // namespace crsm_slam
