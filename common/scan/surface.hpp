#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/scan/surface_constants.hpp"

namespace crsm {

/// What lies between the hits of a scan: looked at once, for all who ask.
class Gaps {
 public:
  /// hits_m: 2 x N.
  explicit Gaps(const Eigen::Matrix2Xd& hits_m, const SurfaceConstants& constants = {});

  /// Which neighbouring hits lie on one surface: result[i] speaks of hits i and i + 1.
  ///
  /// Two hits less than `near_m` apart are joined; up to `max_m` apart they are joined if the hit before or the hit
  /// after continues their line: a wall seen at a grazing angle, whose hits are far apart, and not the jump from a near
  /// edge to what lies behind it, nor the small one to a door that stands back: drawn aslant it would lie where the
  /// robot saw it from, and hold the robot there.
  std::vector<bool> FindSurfaces(double near_m, double max_m) const;

 private:
  struct Gap {
    double length_m;
    bool continued;  ///< by the hit before or after
  };
  std::vector<Gap> gaps_;
};

/// Whether the way from one hit to the next lies within 5 degrees of the beam. Three hits on three things, one behind
/// another, look like a wall that is seen so flat: far apart they are none that may be drawn.
bool IsAlongBeam(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, const SurfaceConstants& constants = {});

}  // namespace crsm
