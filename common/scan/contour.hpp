#pragma once

#include <Eigen/Core>

#include "common/scan/surface.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// How the hits of a scan are weighed.
struct ContourConstants {
  double most_of_gap = 20.0;  ///< weight of a gap as long as the cap, or longer
  int most_pieces = 7;        ///< of a gap: what each of them weighs is a whole number too
};

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
/// hits_m: of the rays, as ComputeHits gives them. gaps: between these.
Contour TraceContour(const ValidRays& rays, const Eigen::Matrix2Xd& hits_m, const Gaps& gaps, double cap_m,
                     const ContourConstants& constants = {});

}  // namespace crsm
