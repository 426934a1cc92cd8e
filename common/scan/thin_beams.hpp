#pragma once

#include <cstddef>
#include <string>

#include "common/scan/laser_scan.hpp"

namespace crsm {

/// Most beams that a source takes of one scan; it keeps kMaxBeams of them at most (ThinBeams).
inline constexpr std::size_t kMostBeamsRead = 65536;

/// Keeps every n-th beam of a scan with more than kMaxBeams, for the smallest n that does. Returns what was done, in
/// words for people: "scans have 5520 beams, of which one in 2 is used, because 4096 are the most"; empty where all
/// beams stay.
std::string ThinBeams(LaserScan& scan);

}  // namespace crsm
