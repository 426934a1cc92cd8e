#pragma once

#include <span>
#include <vector>

#include "common/map_updater.hpp"
#include "services/runtime/wire.hpp"

namespace crsm {

/// What a match changed in the map, for everybody: one message, or more where it would be larger than about 32 KB (the
/// kernel's default receive buffer holds 200 KB).
std::vector<map_delta_t> MakeParts(const MapDelta& delta, const ScanMatch& match, const MapGeometry& geometry);

/// The next page of what a replica lacks: tiles that changed since its version, whole, and matches that it does not
/// have. history: all matches answered so far.
map_delta_t MakePage(const map_request_t& request, const MapUpdater& updater, std::span<const ScanMatch> history);

}  // namespace crsm
