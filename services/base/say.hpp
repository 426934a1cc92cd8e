#pragma once

#include <string>

namespace crsm {

/// Says a line on stderr, WithoutControls: names come from files and devices. A log that cannot be written, on a full
/// disk say, is no reason to stop.
void Say(const std::string& line);

}  // namespace crsm
