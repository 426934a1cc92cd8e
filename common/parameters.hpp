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

/// Which beams of a scan count as measurements, and where they point.
struct ScanParameters {
  double range_min_m = 0.05;
  double range_max_m = 30.0;
  double angle_scale = 1.0;  ///< of beams' angles from the laser's x axis, against the nominal ones
  double sweep_s = 0.0;      ///< from the first beam to the last, negative where that is the first; 0: all at once
  bool beam_times = true;    ///< a scan's own times of its beams are believed, and sweep_s is for those without
  bool botlab_clockwise = true;
};

enum class SelectionMethod { kAll, kUniform, kDensity, kSegments };
enum class DensityScaleMode { kScan, kPrevious };

/// Which rays of a scan are matched. Source: section 4.
struct SelectionParameters {
  SelectionMethod method = SelectionMethod::kSegments;
  int uniform_step = 5;           ///< SkipStep of Eq. 1
  int density_rays = 40;          ///< N of Eq. 4
  double edge_threshold_m = 0.5;  ///< D_THRES
  int gap_threshold_rays = 10;    ///< RAY_THRES
  int rays_min = 60;
  int rays_max = 90;
  DensityScaleMode density_scale_mode = DensityScaleMode::kScan;
  bool limit_edges = true;
};

enum class ClimbMode { kFixed, kShrinking };

/// How the pose is searched. Source: section 5.
struct MatchParameters {
  std::uint64_t seed = 1;
  int num_evaluations = 700;        ///< N_HC
  double satisfying_fitness = 1.0;  ///< the search stops here
  double window_m = 0.4;            ///< re-initialisation bound, +- in x and y
  double window_rad = 0.25;         ///< re-initialisation bound, +- in yaw
  double mutation_m = 0.1;          ///< mutation bound, +- in x and y
  double mutation_rad = 0.1;        ///< mutation bound, +- in yaw
  double unexplored_score = 0.0;    ///< for a ray that ends in an unexplored cell
  ClimbMode climb = ClimbMode::kShrinking;
  int restart_draws = 6;  ///< random poses, on the best of which a climb begins again
  bool interpolate = true;
  bool velocity_model = true;
  bool odometry = false;
  bool final_climb = true;
  bool smooth_climb = false;
  double spacing_cap_m = 0.3;
  double summit_rad = 0.02;       ///< half the width of the optimum in whose middle the yaw is
  double pull_per_m2 = 0.5;       ///< weight of the distance from the initial guess
  double axis_pull_per_m2 = 7.0;  ///< ... along an axis that the walls leave open
  double axis_window_m = 1.0;     ///< +- along such an axis
  double good_ratio = 0.95;       ///< of the baseline fitness: the search stops here
  double lost_ratio = 0.7;        ///< ... below here the wide window is searched, and then the scan is lost
  int wide_evaluations = 10000;
  double wide_window_m = 0.6;                 ///< +- in x and y
  double wide_window_rad = 1.2;               ///< +- in yaw
  std::optional<Pose2> start = std::nullopt;  ///< T_map_laser of the first scan on a finished map, if it is known
};

/// How a scan changes the map. Source: section 6.
struct UpdateParameters {
  double cell_size_m = 0.05;
  double occupied_density = 6.0;  ///< Dens_occu
  bool sparseness_intensity = true;
  double intensity = 0.1;  ///< where it does not follow the sparseness
  double intensity_min = 0.04;
  double intensity_max = 0.2;
  double first_intensity = 0.85;  ///< of a cell's first update, at least
  double erase_behind_m = 0.1;    ///< where hits are, behind them: what was drawn there fades
  double hit_spread = 2.5;        ///< how much of the cells around it a hit occupies
  bool join_hits = true;
  double join_max_m = 2.0;
  double update_distance_m = 0.3;
  double update_angle_rad = 0.25;
};

/// What is known of places that the robot comes back to.
struct LoopParameters {
  bool loops = true;
  double local_map_m = 40.0;  ///< along the graph: what lies further from the robot is not matched
  int lag = 10;               ///< keyframes until what one has brought takes effect
  int lost_scans_max = 3;     ///< after so many lost scans in a row a new trajectory begins; 0: never
  double gap_max_s = 8.0;     ///< after a longer gap only a robot that stood still goes on; 0: after any
};

struct Parameters {
  ScanParameters scan;
  SelectionParameters selection;
  MatchParameters match;
  UpdateParameters update;
  LoopParameters loops;
};

/// Which programs a parameter concerns.
enum class ParameterGroup { kSeed, kOdometry, kLaser, kScan, kSelection, kMatch, kUpdate, kLoops };

struct ParameterInfo {
  ParameterGroup group;
  const char* key;   ///< in a configuration file; the flag is the same with dashes
  const char* help;  ///< one line with the unit and the source
};

// Below: the one list of all parameters, in four parts.

template <class Visitor>
void VisitScanParameters(ScanParameters& scan, Visitor&& visit) {
  using enum ParameterGroup;
  visit({kScan, "range_min_m", "shorter readings are ignored [m]"}, scan.range_min_m, 0.0, 10.0);
  visit({kScan, "range_max_m", "maximum range of the laser [m]; readings beyond 95 % of it are ignored (section 4)"},
        scan.range_max_m, 0.1, kLongestRange_m);
  visit({kScan, "angle_scale",
         "factor that corrects all beam angles, measured from straight ahead: true angle / nominal angle"},
        scan.angle_scale, 0.9, 1.1);
  visit({kLaser, "sweep_s",
         "time from the first to the last beam of a scan [s], by which it is deskewed; negative: the last beam is "
         "measured first; 0: no deskewing. As a flag it wins over the times in the messages"},
        scan.sweep_s, -1.0, 1.0);
  visit({kLaser, "beam_times", "believe the times of the beams in the messages; sweep_s is for scans without them"},
        scan.beam_times);
  visit({kLaser, "botlab_clockwise",
         "the angles of a botlab.lidar_t run clockwise; today's mbot driver needs --no-botlab-clockwise"},
        scan.botlab_clockwise);
}

template <class Visitor>
void VisitSelectionParameters(SelectionParameters& selection, Visitor&& visit) {
  using enum ParameterGroup;
  constexpr std::array<std::string_view, 4> kMethods{"all", "uniform", "density", "segments"};
  constexpr std::array<std::string_view, 2> kScaleModes{"scan", "previous"};
  visit({kSelection, "method", "how critical rays are picked (section 4)"}, selection.method, kMethods);
  visit({kSelection, "uniform_step", "uniform: every n-th ray (SkipStep, Eq. 1)"}, selection.uniform_step, 1, 4096);
  visit({kSelection, "density_rays", "density: rays to pick (N, Eq. 4)"}, selection.density_rays, 2, 4096);
  visit({kSelection, "edge_threshold_m", "segments: a larger step between neighbouring hits is an edge [m] (D_THRES)"},
        selection.edge_threshold_m, 0.01, 100.0);
  visit({kSelection, "gap_threshold_rays", "segments: at most this many rays lie between two picked ones (RAY_THRES)"},
        selection.gap_threshold_rays, 1, 4096);
  visit({kSelection, "rays_min", "segments: fewest rays to pick"}, selection.rays_min, 2, 4096);
  visit({kSelection, "rays_max", "segments: most rays to pick"}, selection.rays_max, 2, 4096);
  visit(
      {kSelection, "density_scale_mode",
       "segments: scan: find P for each scan; previous: derive P from the count of the previous scan, as in the paper"},
      selection.density_scale_mode, kScaleModes);
  visit({kSelection, "limit_edges", "segments: edges get at most half of rays_max, the widest edges first"},
        selection.limit_edges);
}

template <class Visitor>
void VisitMatchParameters(MatchParameters& match, Visitor&& visit) {
  using enum ParameterGroup;
  constexpr std::array<std::string_view, 2> kClimbs{"fixed", "shrinking"};
  visit({kSeed, "seed", "seed of the random numbers"}, match.seed, std::uint64_t{0}, ~std::uint64_t{0});
  visit({kOdometry, "odometry",
         "use the wheel odometry of the source, as far as it agrees with the laser; what it is worth is learned"},
        match.odometry);
  visit({kMatch, "num_evaluations", "most evaluations of the fitness for a scan (N_HC)"}, match.num_evaluations, 1,
        10000000);
  visit({kMatch, "satisfying_fitness", "the search stops at this fitness, 0 to 1"}, match.satisfying_fitness, 0.0, 1.0);
  visit({kMatch, "window_m", "re-initialisation bound in x and y [m]"}, match.window_m, 0.001, 10.0);
  visit({kMatch, "window_rad", "re-initialisation bound in yaw [rad]"}, match.window_rad, 0.001, 3.2);
  visit({kMatch, "mutation_m", "mutation bound in x and y [m]"}, match.mutation_m, 0.001, 10.0);
  visit({kMatch, "mutation_rad", "mutation bound in yaw [rad]"}, match.mutation_rad, 0.0001, 3.2);
  visit({kMatch, "unexplored_score", "score of a ray that ends in an unexplored cell; a full hit scores 3570"},
        match.unexplored_score, -3570.0, 3570.0);
  visit({kMatch, "climb", "fixed: mutations keep their bound, as in the paper; shrinking: they shrink after failures"},
        match.climb, kClimbs);
  visit({kMatch, "restart_draws", "each restart begins at the best of this many random poses; 1 = the paper"},
        match.restart_draws, 1, 1000);
  visit({kMatch, "interpolate", "fitness between cells by bilinear interpolation"}, match.interpolate);
  visit({kMatch, "velocity_model",
         "the initial guess repeats the last motions; without it, the initial guess is the last pose"},
        match.velocity_model);
  visit({kMatch, "final_climb", "end with a climb that uses all valid rays"}, match.final_climb);
  visit({kMatch, "smooth_climb",
         "the final climb ends with a spline fitness, which is more accurate between cells than the bilinear one"},
        match.smooth_climb);
  visit({kMatch, "spacing_cap_m",
         "final climb: the weight of a ray is the distance to its neighbours, at most this [m]; 0: equal weights"},
        match.spacing_cap_m, 0.0, 100.0);
  visit({kMatch, "summit_rad",
         "final climb: centre the yaw on the optimum, by the fitness up to this far on both sides [rad]; 0: take the "
         "highest fitness"},
        match.summit_rad, 0.0, 0.2);
  visit({kMatch, "pull_per_m2",
         "motion prior: fitness lost per squared distance from the initial guess [1/m^2]; 0 = the paper"},
        match.pull_per_m2, 0.0, 100.0);
  visit({kMatch, "axis_pull_per_m2",
         "motion prior along a degenerate direction, at least; weaker where the walls give some information, stronger "
         "for a robot that drives evenly [1/m^2]; 0: none"},
        match.axis_pull_per_m2, 0.0, 100.0);
  visit({kMatch, "axis_window_m",
         "if a direction is degenerate, search this far along it for a better position [m]; 0: no search"},
        match.axis_window_m, 0.0, 10.0);
  visit({kMatch, "good_ratio",
         "the search stops at this share of the baseline fitness (that of the last scans); 100 = the paper"},
        match.good_ratio, 0.0, 100.0);
  visit({kMatch, "lost_ratio",
         "below this share of the baseline fitness, search the wide window; if that fails, the scan is lost; 0 = the "
         "paper"},
        match.lost_ratio, 0.0, 1.0);
  visit({kMatch, "wide_evaluations", "most evaluations of the fitness in the wide window"}, match.wide_evaluations, 1,
        10000000);
  visit({kMatch, "wide_window_m", "bound of the wide window in x and y [m]; it grows while the robot is lost"},
        match.wide_window_m, 0.001, 10.0);
  visit({kMatch, "wide_window_rad", "bound of the wide window in yaw [rad]; it grows while the robot is lost"},
        match.wide_window_rad, 0.001, 3.2);
}

template <class Visitor>
void VisitUpdateParameters(UpdateParameters& update, Visitor&& visit) {
  using enum ParameterGroup;
  visit({kUpdate, "cell_size_m", "side of a map cell [m]"}, update.cell_size_m, 0.005, 1.0);
  visit(
      {kUpdate, "occupied_density", "how many times stronger an occupied cell is updated than a free one (Dens_occu)"},
      update.occupied_density, 1.0, 100.0);
  visit({kUpdate, "sparseness_intensity", "the intensity of the update follows the scan's mean sparseness"},
        update.sparseness_intensity);
  visit({kUpdate, "intensity", "intensity of the update with --no-sparseness-intensity"}, update.intensity, 0.001, 1.0);
  visit({kUpdate, "intensity_min", "lowest intensity with --sparseness-intensity"}, update.intensity_min, 0.0, 1.0);
  visit({kUpdate, "intensity_max", "highest intensity with --sparseness-intensity"}, update.intensity_max, 0.0, 1.0);
  visit({kUpdate, "erase_behind_m", "earlier hits fade up to this far behind a new hit [m]; 0 = the paper"},
        update.erase_behind_m, 0.0, 1.0);
  visit({kUpdate, "first_intensity", "the first update of an unexplored cell is at least this intense; 0 = the paper"},
        update.first_intensity, 0.0, 0.95);
  visit({kUpdate, "hit_spread",
         "a hit occupies the four cells around it, each by this times its bilinear weight; 0: its own cell only, as in "
         "the paper"},
        update.hit_spread, 0.0, 4.0);
  visit({kUpdate, "join_hits", "neighbouring hits on one surface become a line of occupied cells"}, update.join_hits);
  visit({kUpdate, "join_max_m", "hits further apart than this are never joined [m]"}, update.join_max_m, 0.0, 10.0);
  visit({kUpdate, "update_distance_m", "a scan updates the map after this much motion [m] ..."},
        update.update_distance_m, 0.0, 10.0);
  visit({kUpdate, "update_angle_rad", "... or this much turning [rad]"}, update.update_angle_rad, 0.0, 3.2);
}

template <class Visitor>
void VisitLoopParameters(LoopParameters& loops, Visitor&& visit) {
  using enum ParameterGroup;
  visit({kLoops, "loops", "detect loop closures and correct the map"}, loops.loops);
  visit({kLoops, "local_map_m",
         "length of the local map, along the pose graph [m]; scans are matched to the local map alone"},
        loops.local_map_m, 5.0, 1000.0);
  visit({kLoops, "loop_lag", "a loop closure corrects the map this many keyframes later"}, loops.lag, 1, 1000);
  visit({kLoops, "lost_scans_max",
         "after this many lost scans in a row, begin a new trajectory, which loop closures join with the others; "
         "0: never"},
        loops.lost_scans_max, 0, 1000000);
  visit({kLoops, "gap_max_s",
         "after a longer gap between scans, begin a new trajectory, unless the robot stands where it stood [s]; "
         "0: never"},
        loops.gap_max_s, 0.0, 1e9);
}

/// Calls `visit(info, value, low, high)` for every number, `visit(info, flag)` for every switch and
/// `visit(info, choice, names)` for every choice. The one list of all parameters: flags, configuration files,
/// presets, summaries and checks are made from it.
template <class Visitor>
void VisitParameters(Parameters& p, Visitor&& visit) {
  VisitScanParameters(p.scan, visit);
  VisitSelectionParameters(p.selection, visit);
  VisitMatchParameters(p.match, visit);
  VisitUpdateParameters(p.update, visit);
  VisitLoopParameters(p.loops, visit);
}

using ParameterValue = std::variant<bool, std::int64_t, std::uint64_t, double, std::string>;

/// Values by their keys, in an order that means something.
using NamedValues = std::vector<std::pair<std::string, ParameterValue>>;

/// Every parameter by its key, in the order of VisitParameters; of some groups only.
NamedValues ListParameters(const Parameters& parameters);
NamedValues ListParameters(const Parameters& parameters, const std::vector<ParameterGroup>& groups);

/// Throws std::runtime_error, one line that names the keys, if two parameters contradict each other.
void CheckConsistency(const Parameters& parameters);

}  // namespace crsm
