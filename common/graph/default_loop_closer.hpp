#pragma once

#include "common/graph/graph_constants.hpp"
#include "common/graph/loop_closer.hpp"
#include "common/map/map_updater.hpp"
#include "common/match/match_constants.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// Makes the loop closer that is used where no other is given.
MakeLoopCloser DefaultLoopCloser(const LoopParameters& parameters, const DrawingRules& drawing,
                                 const GraphConstants& constants = {}, const MatchConstants& match = {});

}  // namespace crsm
