#pragma once

#include <limits>
#include <string>

#include "common/scan/laser_scan.hpp"
#include "services/settings/command_line.hpp"

namespace crsm {

/// Looks at the first scans of a log for what a user would otherwise have to know of the laser: the range that stands
/// for "no return", and when its beams are measured. Sets what they show, unless a flag says otherwise, and says in one
/// line what the laser is; a flag or preset that cannot fit the scans is named. A laser that is live is not asked.
/// Throws as OpenLaserSource does.
void StudyLaser(const std::string& log, CommandLine& command_line);

/// How far a log's hits go.
struct RangeLimit {
  float range_m = std::numeric_limits<float>::infinity();  ///< from here on nothing was measured

  /// What was not measured becomes 0: no return.
  void Apply(LaserScan& scan) const;
};

/// The same for a further log of a map, whose parameters are those of the first one: a log may have a number of its own
/// for "no return".
RangeLimit StudyFurtherLog(const std::string& log, const CommandLine& command_line);

}  // namespace crsm
