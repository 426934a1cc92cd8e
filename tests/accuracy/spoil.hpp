#pragma once

#include <string>
#include <vector>

#include "accuracy/run.hpp"

namespace crsm {

/// The ways in which scans can be spoilt so that their map comes out wrong.
std::vector<std::string> WaysToSpoil();

/// Spoils the scans in one of these ways, the same way each time. Throws std::invalid_argument if there is none of that
/// name.
Recording Spoil(Recording recording, const std::string& way);

}  // namespace crsm
