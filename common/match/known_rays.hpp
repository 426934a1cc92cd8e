#pragma once

#include <Eigen/Core>

#include "common/match/match_constants.hpp"
#include "common/match/scored_map.hpp"
#include "common/math/pose2.hpp"
#include "common/scan/contour.hpp"

namespace crsm {

/// Of each ray of a scan, whether a map tells anything of it.
///
/// A ray that ends in what is unexplored scores as one that does not fit. Along a corridor whose walls are not drawn to
/// their end that favours the pose from which the fewest rays reach beyond: the robot would seem to stand. So where two
/// poses are compared, only rays count that the map knows from both.
using KnownRays = Eigen::Array<bool, Eigen::Dynamic, 1>;

/// Along which poses are compared, and how.
struct DegenerateAxis {
  Eigen::Vector2d direction;    ///< unit vector, map frame
  bool held_by_wheels = false;  ///< then a few cells across it are no wall: the drawn end of a wall looks like one
  MatchConstants::KnownRays constants = {};
};

/// Rays end in explored cells, or pass through a wall before they end, or end just behind one. points_m: 2 x N, laser
/// frame.
KnownRays FindKnownRays(const ByteMap& map, const Eigen::Matrix2Xd& points_m, const Pose2& T_map_laser,
                        const DegenerateAxis& axis);

/// The same, of some of the rays alone: of the others nothing is told.
KnownRays FindKnownRays(const ByteMap& map, const Eigen::Matrix2Xd& points_m, const Pose2& T_map_laser,
                        const DegenerateAxis& axis, const KnownRays& among);

/// These rays alone.
RaysInCells SelectRays(const ScoredMap& map, const Contour& contour, const KnownRays& rays);

/// How much better a scan fits at one pose than at another, by the rays that are known from both: a share of all rays.
/// known_from: those that are known from there. smooth: by ScoredMap::SmoothFitness.
double ComputeGain(const ScoredMap& map, const Contour& contour, const DegenerateAxis& axis, const Pose2& from,
                   const KnownRays& known_from, const Pose2& to, bool smooth = false);

}  // namespace crsm
