#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose2.hpp"
#include "common/parameters.hpp"

namespace crsm {

/// A way through a building: a simulated world or a real log.
struct Drive {
  std::string source;                   ///< sim:NAME, or the path of a log
  std::string preset = {};              ///< of scripts/presets; empty for none
  std::string relations = {};           ///< the path of what is known about the log; empty for none
  Pose2 T_robot_laser = {};             ///< where the laser stands on the robot, whose poses the relations are of
  std::vector<std::string> flags = {};  ///< besides those of the preset
  int every = 1;                        ///< of the scans, one in so many is there
};

/// Places that are alike are 4 m apart or more: a loop that is off by less leads to the right place, if not always to
/// the decimetre along a corridor that holds little.
inline constexpr double kRightLoop_m = 1.0;

/// What one run came to. Errors are 0 where no truth is known.
struct Outcome {
  double worst_m = 0.0;       ///< simulated: the largest distance of a pose from the truth; logs: of a relation
  double error_m = 0.0;       ///< simulated: the root of the mean square of that distance; logs: mean of the relations
  double aligned_m = 0.0;     ///< simulated: as error_m, once the path is aligned with the true one
  double lost = 0.0;          ///< share of the scans
  double mean_fitness = 0.0;  ///< of the scans that were matched
  int num_loops = 0;          ///< closed
  double worst_loop_m = 0.0;  ///< simulated: how far a loop is from the truth, at most
  std::vector<double> cpu_s;  ///< of each scan, without the search for loops
};

/// The parameters of a program that was started with this preset and seed, and no flags but these. Throws
/// std::runtime_error if there is no such preset or flag.
Parameters ShippedParameters(const std::string& preset, std::uint64_t seed, const std::vector<std::string>& flags = {});

/// Maps the drive in this process. Throws std::runtime_error if the source or the relations cannot be read.
Outcome Map(const Drive& drive, const Parameters& parameters);

}  // namespace crsm
