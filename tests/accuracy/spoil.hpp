#pragma once

#include <string>
#include <vector>

#include "common/scan/laser_scan.hpp"

namespace crsm {

/// The ways in which scans can be spoilt so that their map comes out wrong.
std::vector<std::string> WaysToSpoil();

/// Spoils scans in one of these ways, the same way each time. Throws std::invalid_argument if there is none of that
/// name.
std::vector<LaserScan> Spoil(std::vector<LaserScan> scans, const std::string& way);

}  // namespace crsm
