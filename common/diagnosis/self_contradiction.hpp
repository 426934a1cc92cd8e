#pragma once

#include <cstdint>
#include <span>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/math/point.hpp"
#include "common/math/pose2.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// A scan where it was matched.
struct PlacedRays {
  ValidRays rays;  ///< deskewed
  Pose2 T_map_laser;
  double path_m = 0.0;  ///< length of the path up to there
};

/// How scans that were taken at about the same place, long apart along the path, go together.
struct SelfContradiction {
  std::int64_t num_looks = 0;  ///< scans that were compared with another one
  double share = 0.0;          ///< of those, how many contradict it, [0, 1]
  /// Where most contradict each other, among the squares of 2 m in which scans were compared often: map frame [m].
  Point worst_place;
  double worst_share = 0.0;  ///< there, [0, 1]; 0 where there is no such square
};

/// A map that was made wrongly contradicts itself where the robot was twice: of two scans taken within a metre of each
/// other one has its hits where the other sees free ground. The map does not show it: what comes later erases what it
/// contradicts. Two scans contradict each other where more than three in ten of the hits of one, among those that the
/// other sees at all, lie in front of what that one sees.
///
/// scans: in the order of their path. Looks at no more than 1,000 pairs, the same ones each time.
SelfContradiction FindSelfContradiction(std::span<const PlacedRays> scans,
                                        const DiagnosisConstants::SelfContradiction& constants = {});

}  // namespace crsm
