#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/logs/laser_source.hpp"
#include "common/math/pose2.hpp"
#include "common/metrics/trajectory.hpp"
#include "common/parameters.hpp"
#include "common/slam.hpp"

namespace crsm {

// The harness of all runs with a truth: a recording of a simulated world or a real log is mapped in this process.

/// All that a source gives.
struct Recording {
  std::vector<LaserScan> scans;
  std::vector<std::optional<Pose2>> odometry;  ///< T_odom_robot of each scan; what is missing is none
  bool uses_odometry = false;                  ///< whether a map is made with it
  Trajectory truth;                            ///< of a simulated world
};

/// One scan in `every`.
Recording Record(LaserSource& source, int every = 1);
/// With the parameters' seed. Throws std::runtime_error if the source cannot be read.
Recording Record(const std::string& source, const Parameters& parameters, int every = 1);

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
  double worst_loop_m = 0.0;  ///< simulated: how far a loop is from the truth, at most
  std::vector<double> cpu_s;  ///< of each scan, without the search for loops
  std::vector<ScanMatch> matches;  ///< where loops have moved them to
  std::shared_ptr<const ByteMap> map;
  KeyframeGraph graph;
  std::shared_ptr<const Slam> slam;  ///< which made it
};

/// How far a loop is from the truth [m]; nothing where that is not known.
std::optional<double> ErrorOf(const Loop& loop, const KeyframeGraph& graph, const Trajectory& truth);

/// The parameters of a program that was started with this preset and seed, and no flags but these. Throws
/// std::runtime_error if there is no such preset or flag.
Parameters ShippedParameters(const std::string& preset, std::uint64_t seed, const std::vector<std::string>& flags = {});

/// Maps a recording. look: called after each scan.
Outcome Map(const Recording& recording, const Parameters& parameters,
            const std::function<void(const Slam::Step&)>& look = {});

/// Maps what was recorded on a drive. Throws std::runtime_error if its relations cannot be read.
Outcome Map(const Drive& drive, const Recording& recording, const Parameters& parameters);
/// Throws std::runtime_error if the files of the drive cannot be read.
Outcome Map(const Drive& drive, const Parameters& parameters);

double Median(std::vector<double> values);

}  // namespace crsm
