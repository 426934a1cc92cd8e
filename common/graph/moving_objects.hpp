#pragma once

#include <deque>

#include "common/map/drawing_constants.hpp"
#include "common/math/pose2.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

/// Keeps out of the map who walks with the robot, before, beside or behind it, and parts of the robot itself. They
/// would leave a ghost at every step, and hold the robot where they were drawn.
///
/// An object is a run of hits that are close to each other. One that is near, no broader than people, and in front of
/// what is beside it, is drawn once most of it is where something was seen some way ago, or where that scan did not
/// look. So a door that closes is drawn at once: it is one with the wall beside it.
class MovingObjectFilter {
 public:
  explicit MovingObjectFilter(const DrawingConstants& constants = {}) : constants_(constants) {}

  /// The rays of a scan that may be drawn, in their order; all of them if that were less than a quarter, or if the
  /// robot has driven far since the last scan that was drawn. rays: measured at one instant.
  ValidRays Filter(const ValidRays& rays, const Pose2& T_map_laser) const;

  /// A scan was drawn there. rays: all of it.
  void Add(const ValidRays& rays, const Pose2& T_map_laser);
  /// What was at T_old on the map is at T_new_old * T_old.
  void Move(const Pose2& T_new_old);
  /// The robot is somewhere else.
  void Clear() { seen_.clear(); }

 private:
  struct Seen {
    double path_m;  ///< driven up to it
    Pose2 T_map_laser;
    ValidRays rays;
  };

  DrawingConstants constants_;
  std::deque<Seen> seen_;  ///< oldest first: one that is some way ago, and those since
  Pose2 T_map_last_;       ///< of the last scan that was drawn ...
  double path_m_ = 0.0;    ///< ... and the way along such scans up to it
};

}  // namespace crsm
