#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "common/map/byte_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/match/place_search.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// Where a robot may be that was seen last so long ago that it may have gone further than random climbs find, as in
/// logs with a scan a metre: how far from the initial guess. It follows from the time since the last scan, and from how
/// fast the robot moved and turned over the last matches. Nothing where scans follow each other closely as a rule, or
/// nothing was matched yet. recent: as of TrackingState.
std::optional<PlaceReach> FindFarWindow(std::span<const ScanMatch> recent, std::int64_t utime,
                                        const MatchConstants::FarSearch& constants = {});

/// The best place in the window by branch and bound, to two cells of 0.1 m; nothing where too little fits, or another
/// place fits nearly as well. hits_m: 2 x N, laser frame, in order of rising angle.
std::optional<Pose2> SearchFar(const ByteMap& map, const Eigen::Matrix2Xd& hits_m, const Pose2& initial_guess,
                               const PlaceReach& reach, const MatchConstants& constants = {});

}  // namespace crsm
