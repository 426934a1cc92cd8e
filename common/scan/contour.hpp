#pragma once

#include <Eigen/Core>

#include "common/scan/valid_rays.hpp"

namespace crsm {

/// Points on what a scan saw.
struct Contour {
  Eigen::Matrix2Xd points_m;  ///< 2 x N, laser frame, the hits among them
  Eigen::ArrayXi weights;     ///< of N points, from 1
};

/// The hits of a scan, weighted by the length of contour that each stands for: half the distance to its neighbours on
/// either side, of which no more than `cap_m` counts; 1 to 21. Along a corridor most rays end on its near walls, which
/// do not tell how far the robot went; the few that do lie far apart.
///
/// A longer gap between two hits of one surface weighs no more, but lies in points along it: a wall that is seen so
/// flat that its hits are metres apart is a wall between them too. Alone they would fit best onto those of the scan
/// before, and a robot on its way through a bare corridor would seem to stand. cap_m = 0: the hits, all alike.
///
/// hits_m: of the rays, as ComputeHits gives them.
Contour TraceContour(const ValidRays& rays, const Eigen::Matrix2Xd& hits_m, double cap_m);

}  // namespace crsm
