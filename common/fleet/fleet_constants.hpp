#pragma once

#include "common/graph/graph_constants.hpp"
#include "common/match/match_constants.hpp"

namespace crsm {

/// All that the common map of a fleet takes for granted, besides what each robot's own pose graph does.
struct FleetConstants {
  GraphConstants graph = {};
  MatchConstants match = {};

  double near_every_m = 5.0;     ///< along the path: where robots are joined, whether others were near is asked
  double agrees_m = 0.05;        ///< a loop that hardly differs from the graph is no reason to move the map: a cell ...
  double agrees_rad = 0.01;      ///< ... and what that is at 5 m
  double same_loop_m = 10.0;     ///< along the path between two loops that only say once more what the graph says
  double robot_m = 0.6;          ///< around a robot's laser: what others see there is the robot, and no wall
  double robot_stays_s = 600.0;  ///< after its newest keyframe a robot is taken to stand there
  int samples = 30;              ///< of the posterior, for the covariance of a robot's pose
};

}  // namespace crsm
