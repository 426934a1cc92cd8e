#pragma once

#include <vector>

#include "common/map/map_delta.hpp"
#include "common/map/map_geometry.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "services/replica/growing_message.hpp"

namespace crsm {

/// What a scan changed in the map: one message, or more where it would be too large.
std::vector<map_delta_t> MakeParts(const MapDelta& delta, std::int64_t utime, const MapGeometry& geometry,
                                   const AnswerOptions& options, const AfterMatch& after = {});

}  // namespace crsm
