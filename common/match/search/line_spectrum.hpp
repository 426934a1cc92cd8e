#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>

#include "common/match/match_constants.hpp"

namespace crsm {

/// How much of some points lies on straight lines, by the direction of these, a degree each: it turns with the points,
/// and does not change where they are moved. Its mean is 0, its length 1.
///
/// Source: Censi, Iocchi and Grisetti, "Scan matching in the Hough domain", ICRA 2005 (the Hough spectrum).
using LineSpectrum = std::array<float, 180>;

/// points_m: 2 x N, spread evenly. Of none it is 0.
LineSpectrum ComputeLineSpectrum(const Eigen::Matrix2Xd& points_m, const MatchConstants::LineSpectrum& constants = {});

/// Yaws, by degrees; half a turn more is the same one.
using Turns = std::bitset<180>;

/// By how much the one is to be turned so that its lines lie along those of the other: the `num` best degrees, and
/// those beside them.
Turns FindBestTurns(const LineSpectrum& fixed, const LineSpectrum& turned, int num);

}  // namespace crsm
