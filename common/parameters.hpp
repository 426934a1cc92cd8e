#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "common/math/pose2.hpp"

namespace crsm {

inline constexpr double kLongestRange_m = 1000.0;  ///< that any laser may have

/// Whose ray selector, matcher and map updater run: ours, or the text of the paper.
enum class Algorithm { kCrsm, kPaper };

/// Which beams of a scan count as measurements, and where they point.
struct ScanParameters {
  double range_min_m = 0.05;
  double range_max_m = 30.0;
  double angle_scale = 1.0;  ///< of beams' angles from the laser's x axis, against the nominal ones
  double sweep_s = 0.0;      ///< from the first beam to the last, negative where that is the first; 0: all at once
  bool beam_times = true;    ///< a scan's own times of its beams are believed, and sweep_s is for those without
};

/// Which rays of a scan are matched. Source: section 4.
struct SelectionParameters {
  int rays_max = 90;
};

/// How the pose is searched. Source: section 5.
struct MatchParameters {
  std::uint64_t seed = 1;
  std::optional<Pose2> start = std::nullopt;  ///< T_map_laser of the first scan on a finished map, if it is known
};

/// How a scan changes the map. Source: section 6.
struct UpdateParameters {
  double cell_size_m = 0.05;
  double update_distance_m = 0.3;
  double update_angle_rad = 0.25;
  Algorithm algorithm = Algorithm::kCrsm;  ///< that of Parameters
};

/// What is known of places that the robot comes back to.
struct LoopParameters {
  bool loops = true;
  double local_map_m = 40.0;  ///< along the graph: what lies further from the robot is not matched
};

struct Parameters {
  ScanParameters scan = {};
  SelectionParameters selection = {};
  MatchParameters match = {};
  UpdateParameters update = {};
  LoopParameters loops = {};
};

/// Which programs a parameter concerns.
enum class ParameterGroup { kSeed, kLaser, kScan, kSelection, kUpdate, kLoops, kAlgorithm };

struct ParameterInfo {
  ParameterGroup group;
  const char* key;   ///< in a configuration file; the flag is the same with dashes
  const char* help;  ///< one line with the unit and the source
};

/// Calls `visit(info, value, low, high)` for every number, `visit(info, flag)` for every switch and
/// `visit(info, choice, names)` for every choice. The one list of all parameters: flags, configuration files,
/// presets, summaries and checks are made from it.
template <class Visitor>
void VisitParameters(Parameters& p, Visitor&& visit) {
  using enum ParameterGroup;
  constexpr std::array<std::string_view, 2> kAlgorithms{"crsm", "paper"};
  visit({kScan, "range_min_m", "shorter readings are ignored [m]"}, p.scan.range_min_m, 0.0, 10.0);
  visit({kScan, "range_max_m", "maximum range of the laser [m]; readings beyond 95 % of it are ignored (section 4)"},
        p.scan.range_max_m, 0.1, kLongestRange_m);
  visit({kScan, "angle_scale",
         "factor that corrects all beam angles, measured from straight ahead: true angle / nominal angle"},
        p.scan.angle_scale, 0.9, 1.1);
  visit({kLaser, "sweep_s",
         "time from the first to the last beam of a scan [s], by which it is deskewed; negative: the last beam is "
         "measured first; 0: no deskewing. As a flag it wins over the times in the messages"},
        p.scan.sweep_s, -1.0, 1.0);
  visit({kLaser, "beam_times", "believe the times of the beams in the messages; sweep_s is for scans without them"},
        p.scan.beam_times);
  visit({kSelection, "rays_max",
         "most critical rays of a scan; fewer cost less, more are more accurate (the fewest are two thirds of them)"},
        p.selection.rays_max, 6, 4096);
  visit({kSeed, "seed", "seed of the random numbers"}, p.match.seed, std::uint64_t{0}, ~std::uint64_t{0});
  visit({kUpdate, "cell_size_m", "side of a map cell [m]"}, p.update.cell_size_m, 0.005, 1.0);
  visit({kUpdate, "update_distance_m", "a scan updates the map after this much motion [m] ..."},
        p.update.update_distance_m, 0.0, 10.0);
  visit({kUpdate, "update_angle_rad", "... or this much turning [rad]"}, p.update.update_angle_rad, 0.0, 3.2);
  visit({kLoops, "loops", "detect loop closures and correct the map"}, p.loops.loops);
  visit({kLoops, "local_map_m",
         "length of the local map, along the pose graph [m]; scans are matched to the local map alone"},
        p.loops.local_map_m, 5.0, 1000.0);
  visit({kAlgorithm, "algorithm",
         "paper: the selector, matcher and map updater are the text of the paper; see --profile paper"},
        p.update.algorithm, kAlgorithms);
}

using ParameterValue = std::variant<bool, std::int64_t, std::uint64_t, double, std::string>;

/// Values by their keys, in an order that means something.
using NamedValues = std::vector<std::pair<std::string, ParameterValue>>;

/// A value as a flag would say it.
std::string FormatValue(const ParameterValue& value);

/// Every parameter by its key, in the order of VisitParameters; of some groups only.
NamedValues ListParameters(const Parameters& parameters);
NamedValues ListParameters(const Parameters& parameters, const std::vector<ParameterGroup>& groups);

/// Throws std::runtime_error, one line that names the keys, if two parameters contradict each other.
void CheckConsistency(const Parameters& parameters);

}  // namespace crsm
