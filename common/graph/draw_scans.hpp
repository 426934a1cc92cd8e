#pragma once

#include <span>

#include "common/map/byte_map.hpp"
#include "common/map/map_updater.hpp"

namespace crsm {

/// A map of some scans, drawn one after the other.
ByteMap DrawScans(const DrawingRules& drawing, std::span<const PlacedScan> scans);

}  // namespace crsm
