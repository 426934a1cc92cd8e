#pragma once

#include <deque>

#include "common/map/drawing_constants.hpp"
#include "common/math/pose2.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// Keeps out of the map who follows the robot, and parts of the robot itself. They leave a ghost at every step, and
/// hide it from the laser, so that nothing clears it.
///
/// An object is a run of hits that are close to each other. It is not drawn if all of it is where the robot just drove.
/// So a door that closes behind the robot is drawn at once: it is one with the wall beside it.
class MovingObjectFilter {
 public:
  explicit MovingObjectFilter(const DrawingConstants& constants = {}) : constants_(constants) {}

  /// The rays of a scan that may be drawn, in their order; all of them if that were less than half. rays: measured at
  /// one instant.
  ValidRays Filter(const ValidRays& rays, const Pose2& T_map_laser) const;

  /// A scan was drawn there.
  void Add(const Pose2& T_map_laser);
  /// What was at T_old on the map is at T_new_old * T_old.
  void Move(const Pose2& T_new_old);
  /// The robot is somewhere else.
  void Clear() { driven_.clear(); }

 private:
  struct Place {
    double path_m;  ///< driven up to it
    Pose2 T_map_laser;
  };

  DrawingConstants constants_;
  std::deque<Place> driven_;  ///< oldest first
  double path_m_ = 0.0;       ///< along the scans that were drawn ...
  Pose2 T_map_last_;          ///< ... up to this one
};

}  // namespace crsm
