#pragma once

#include <Eigen/Core>

#include "common/map/byte_map.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/pose2.hpp"
#include "common/scan/surface.hpp"

namespace crsm {

/// How well a scan tells where it was taken on the map.
struct PoseUncertainty {
  Eigen::Matrix3d covariance;       ///< of x [m], y [m] and yaw [rad], map frame
  Eigen::Vector2d degenerate_axis;  ///< unit vector, map frame: along it the position is known least
  double degeneracy = 0.0;          ///< of that axis; from 1: nothing seen holds the position along it

  bool degenerate() const { return degeneracy >= 1.0; }
};

/// Unit normals of the surfaces on which hits lie, 2 x N like them; zero where that is not known. Surfaces are joined
/// hits, their direction the chord from some hits before to some hits after.
///
/// hits_m: 2 x N, laser frame, in order of rising angle. gaps: between these.
Eigen::Matrix2Xd ComputeNormals(const Eigen::Matrix2Xd& hits_m, const Gaps& gaps, double cell_size_m,
                                const MatchConstants::Uncertainty& constants = {});

/// Each hit on a mapped wall tells how far the laser is from that wall: across it, not along it. A hit on a post, of
/// which no direction is known and beside which nothing stands on the map, tells both. The covariance is the
/// inverse of what all of them tell together (Censi 2007), no less than what the map itself is good for. It is of the
/// pose on this map; how far the map has drifted from the building since its start no scan can tell.
///
/// hits_m, normals: 2 x N, laser frame.
PoseUncertainty ComputeUncertainty(const Eigen::Matrix2Xd& hits_m, const Eigen::Matrix2Xd& normals,
                                   const Pose2& T_map_laser, const ByteMap& map,
                                   const MatchConstants::Uncertainty& constants = {});

}  // namespace crsm
