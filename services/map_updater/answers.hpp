#pragma once

#include <span>
#include <vector>

#include "common/map_updater.hpp"
#include "services/runtime/wire.hpp"

namespace crsm {

/// What a match changed in the map, for everybody: one message, or more where it would be larger than `most_bytes` on
/// the wire. A tile stays whole: a message of one tile is as large as it is, 4.4 KB at most.
std::vector<map_delta_t> MakeParts(const MapDelta& delta, const ScanMatch& match, const MapGeometry& geometry,
                                   std::size_t most_bytes);

/// The next page of what a replica lacks: tiles that changed since its version, whole, and matches that it does not
/// have. history: all matches answered so far. most_bytes: as of MakeParts.
map_delta_t MakePage(const map_request_t& request, const MapUpdater& updater, std::span<const ScanMatch> history,
                     std::size_t most_bytes);

}  // namespace crsm
