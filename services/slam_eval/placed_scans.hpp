#pragma once

#include <filesystem>
#include <vector>

#include "common/plan/plan.hpp"

namespace crsm {

/// The scans that the map in a folder of results was drawn from, each where it belongs by all that is known. `results`:
/// of a run, or of a piece of its map. Throws std::runtime_error if there is no journal, if it cannot be read, or if
/// that run made no map.
std::vector<PlacedScan> ReadPlacedScans(const std::filesystem::path& results);

}  // namespace crsm
