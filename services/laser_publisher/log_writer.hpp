#pragma once

#include <string>

#include "common/laser_source.hpp"

namespace crsm {

/// Writes all scans to an LCM log that lcm-logplayer plays at the pace of the recording: each event carries its scan's
/// time, and where that goes back the last one. The same scans give the same bytes.
///
/// url: file://PATH?mode=w. Throws std::runtime_error if it is not, or if the file cannot be written.
void WriteLog(LaserSource& source, const std::string& url, const std::string& channel_prefix);

}  // namespace crsm
