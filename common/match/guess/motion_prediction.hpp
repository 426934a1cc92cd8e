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

/// How steady a motion is until `utime`: 1 up to 0.3 s after the last match, later less with the square of the time, in
/// which a robot becomes faster or slower. 1 if there was no match: the pose is not guessed from a motion.
double ComputeSteadiness(std::span<const ScanMatch> recent, std::int64_t utime,
                         const MatchConstants::MotionPrior& constants = {});

}  // namespace crsm
