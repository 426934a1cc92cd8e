#pragma once

#include <string>

#include "common/logs/laser_source.hpp"

namespace crsm {

/// Writes all scans to an LCM log that lcm-logplayer plays at the pace of the recording.
///
/// url: file://PATH?mode=w. Throws std::runtime_error if it is not, if the file cannot be written, or if it is the one
/// that the scans are read from (source_name).
void WriteLog(LaserSource& source, const std::string& source_name, const std::string& url,
              const std::string& channel_prefix, bool with_odometry);

}  // namespace crsm
