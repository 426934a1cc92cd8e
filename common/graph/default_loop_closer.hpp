#pragma once

#include "common/graph/loop_closer.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// Makes the loop closer that is used where no other is given.
MakeLoopCloser DefaultLoopCloser(const LoopParameters& parameters, const UpdateParameters& drawing);

}  // namespace crsm
