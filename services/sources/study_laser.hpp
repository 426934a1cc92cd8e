#pragma once

#include <string>

#include "services/settings/command_line.hpp"

namespace crsm {

/// Looks at the first scans of a log for what a user would otherwise have to know of the laser: the range that stands
/// for "no return", and when its beams are measured. Sets what they show, unless a flag says otherwise, and says in one
/// line what the laser is; a flag or preset that cannot fit the scans is named. A laser that is live is not asked.
/// Throws as OpenLaserSource does.
void StudyLaser(const std::string& log, CommandLine& command_line);

}  // namespace crsm
