#pragma once

#include <limits>
#include <string>

#include "common/scan/laser_scan.hpp"
#include "services/settings/command_line.hpp"

namespace crsm {

/// Looks at the first scans of a log for what a user would otherwise have to know of the laser: the ranges that stand
/// for "no return", when its beams are measured, and whether the scans are mirror images, which odometry tells (used
/// or not, it is read until it does), or TF where it does not. Sets what they show, unless a flag says otherwise, and
/// says in one line what the laser is; a flag or preset that cannot fit the scans is named. A laser that is live is not
/// asked. Throws as OpenLaserSource does.
void StudyLaser(const std::string& log, CommandLine& command_line);

/// Whether the scans of a log are mirror images, and to be turned round, as StudyLaser will set it.
bool FindMirrored(const std::string& log, const CommandLine& command_line);

/// What the scans of a further log need before they are mapped with the parameters of the first one.
struct ScanCorrection {
  float range_m = std::numeric_limits<float>::infinity();  ///< from here on nothing was measured
  bool is_mirrored = false;                                ///< against the first one

  /// What was not measured becomes 0: no return. Mirror images are turned round.
  LaserScan Apply(LaserScan scan) const;
};

/// The same for a further log of a map, whose parameters are those of the first one: a log may have a number of its own
/// for "no return", and a laser that hangs upside down. Where nothing tells, its scans are read as those of the first
/// log are: recorders that split a bag write the static TF into the first part alone.
ScanCorrection StudyFurtherLog(const std::string& log, const CommandLine& command_line);

}  // namespace crsm
