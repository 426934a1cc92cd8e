#pragma once

#include <span>

#include "common/match/match_constants.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// Where to look for a scan before it is matched: the last pose, or the last motions repeated (section 5.3,
/// "the presumed new robot transformation, based on the speed or the kinematic model").
///
/// recent: the last matches, oldest first; at least one, and more than ten change nothing. Lasers turn steadily and
/// loggers stamp unsteadily: a motion is one from scan to scan, whatever the times say. The pose of a lost scan is a
/// guess and tells no speed.
Pose2 PredictPose(std::span<const ScanMatch> recent, const MatchConstants::Prediction& constants = {});

}  // namespace crsm
