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
  double sweep_s = 0.0;      ///< from the first beam to the last; 0: all are measured at once
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
  double summit_rad = 0.02;       ///< half the width of the summit in whose middle the yaw is
  double pull_per_m2 = 0.5;       ///< weight of the distance from the presumed pose
  double axis_pull_per_m2 = 7.0;  ///< ... along an axis that the walls leave open
  double axis_window_m = 1.0;     ///< +- along such an axis
  double good_ratio = 0.95;       ///< of the usual fitness: the search stops here
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
  double erase_behind_m = 0.1;   ///< where hits are, behind them: what was drawn there fades
  double hit_spread = 2.5;       ///< how much of the cells around it a hit occupies
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
  visit({kScan, "range_min_m", "shorter readings are no measurements [m]"}, scan.range_min_m, 0.0, 10.0);
  visit({kScan, "range_max_m",
         "maximum range of the laser [m]; readings beyond 95 % of it are no measurements (section 4)"},
        scan.range_max_m, 0.1, kLongestRange_m);
  visit({kScan, "angle_scale", "the angle of a beam from straight ahead, as a share of the nominal one"},
        scan.angle_scale, 0.9, 1.1);
  visit(
      {kScan, "sweep_s",
       "time from the first beam of a scan to the last [s], where the scan does not say when its beams were measured: "
       "it is deskewed by how the laser moves; 0: not at all"},
      scan.sweep_s, 0.0, 1.0);
  visit({kLaser, "botlab_clockwise",
         "angles of a botlab.lidar_t run clockwise; --no-botlab-clockwise for the driver of today's mbot"},
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
  visit({kSelection, "gap_threshold_rays", "segments: no more rays than this between picked ones (RAY_THRES)"},
        selection.gap_threshold_rays, 1, 4096);
  visit({kSelection, "rays_min", "segments: fewest rays to pick"}, selection.rays_min, 2, 4096);
  visit({kSelection, "rays_max", "segments: most rays to pick"}, selection.rays_max, 2, 4096);
  visit({kSelection, "density_scale_mode",
         "segments: P is found for each scan, or follows the count of the previous scan as in the paper"},
        selection.density_scale_mode, kScaleModes);
  visit({kSelection, "limit_edges", "segments: edges may take half of rays_max, the widest first"},
        selection.limit_edges);
}

template <class Visitor>
void VisitMatchParameters(MatchParameters& match, Visitor&& visit) {
  using enum ParameterGroup;
  constexpr std::array<std::string_view, 2> kClimbs{"fixed", "shrinking"};
  visit({kSeed, "seed", "of the random numbers"}, match.seed, std::uint64_t{0}, ~std::uint64_t{0});
  visit({kOdometry, "odometry", "start from the motion by odometry, where the source has some that can be trusted"},
        match.odometry);
  visit({kMatch, "num_evaluations", "most evaluations of the fitness for a scan (N_HC)"}, match.num_evaluations, 1,
        10000000);
  visit({kMatch, "satisfying_fitness", "the search stops at this fitness, 0 to 1"}, match.satisfying_fitness, 0.0, 1.0);
  visit({kMatch, "window_m", "re-initialisation bound in x and y [m]"}, match.window_m, 0.001, 10.0);
  visit({kMatch, "window_rad", "re-initialisation bound in yaw [rad]"}, match.window_rad, 0.001, 3.2);
  visit({kMatch, "mutation_m", "mutation bound in x and y [m]"}, match.mutation_m, 0.001, 10.0);
  visit({kMatch, "mutation_rad", "mutation bound in yaw [rad]"}, match.mutation_rad, 0.0001, 3.2);
  visit({kMatch, "unexplored_score", "for a ray that ends in an unexplored cell, where a full hit scores 3570"},
        match.unexplored_score, -3570.0, 3570.0);
  visit({kMatch, "climb", "mutations keep their bound (the paper), or shrink when they fail"}, match.climb, kClimbs);
  visit({kMatch, "restart_draws", "a climb begins again on the best of so many random poses; 1 = the paper"},
        match.restart_draws, 1, 1000);
  visit({kMatch, "interpolate", "fitness between cells by bilinear interpolation"}, match.interpolate);
  visit({kMatch, "velocity_model", "start from the last motions repeated, not from the last pose"},
        match.velocity_model);
  visit({kMatch, "final_climb", "end with a climb that uses all valid rays"}, match.final_climb);
  visit({kMatch, "smooth_climb",
         "the final climb ends by a fitness that is right between cells too: a spline instead of bilinear"},
        match.smooth_climb);
  visit({kMatch, "spacing_cap_m",
         "in the final climb a ray counts by its distance from its neighbours, up to this [m]; 0: all alike"},
        match.spacing_cap_m, 0.0, 100.0);
  visit({kMatch, "summit_rad",
         "after the final climb the yaw goes to the middle of the summit, as it looks from so far to either side and "
         "from nearer [rad]; 0: to its top"},
        match.summit_rad, 0.0, 0.2);
  visit({kMatch, "pull_per_m2", "fitness lost per squared distance from the presumed pose [1/m^2]; 0 = the paper"},
        match.pull_per_m2, 0.0, 100.0);
  visit({kMatch, "axis_pull_per_m2",
         "... and along an axis that the walls leave open, less where they tell something [1/m^2]; 0: none"},
        match.axis_pull_per_m2, 0.0, 100.0);
  visit({kMatch, "axis_window_m",
         "where the walls leave the position open along an axis, a better one is looked for so far along it [m]; 0: "
         "none"},
        match.axis_window_m, 0.0, 10.0);
  visit({kMatch, "good_ratio", "the search stops at this share of the fitness of the last scans; 100 = the paper"},
        match.good_ratio, 0.0, 100.0);
  visit(
      {kMatch, "lost_ratio", "below this share the wide window is searched, and then the scan is lost; 0 = the paper"},
      match.lost_ratio, 0.0, 1.0);
  visit({kMatch, "wide_evaluations", "most evaluations of the fitness in the wide window"}, match.wide_evaluations, 1,
        10000000);
  visit({kMatch, "wide_window_m", "bound of the wide window in x and y [m], wider while the robot is lost"},
        match.wide_window_m, 0.001, 10.0);
  visit({kMatch, "wide_window_rad", "bound of the wide window in yaw [rad], wider while the robot is lost"},
        match.wide_window_rad, 0.001, 3.2);
}

template <class Visitor>
void VisitUpdateParameters(UpdateParameters& update, Visitor&& visit) {
  using enum ParameterGroup;
  visit({kUpdate, "cell_size_m", "side of a map cell [m]"}, update.cell_size_m, 0.005, 1.0);
  visit({kUpdate, "occupied_density", "how much more an occupied cell is updated than a free one (Dens_occu)"},
        update.occupied_density, 1.0, 100.0);
  visit({kUpdate, "sparseness_intensity", "the intensity of the update follows the scan's mean sparseness"},
        update.sparseness_intensity);
  visit({kUpdate, "intensity", "of the update where it does not follow the sparseness"}, update.intensity, 0.001, 1.0);
  visit({kUpdate, "intensity_min", "... and where it does, never below this"}, update.intensity_min, 0.0, 1.0);
  visit({kUpdate, "intensity_max", "... nor above this"}, update.intensity_max, 0.0, 1.0);
  visit({kUpdate, "erase_behind_m", "so far behind a hit fades what was drawn there [m]; 0 = the paper"},
        update.erase_behind_m, 0.0, 1.0);
  visit({kUpdate, "first_intensity", "the first update of an unexplored cell is at least this intense; 0 = the paper"},
        update.first_intensity, 0.0, 0.95);
  visit({kUpdate, "hit_spread",
         "a hit occupies the four cells around it, each by this times its bilinear share; 0: its own only, the paper"},
        update.hit_spread, 0.0, 4.0);
  visit({kUpdate, "join_hits", "neighbouring hits on one surface become a line of occupied cells"}, update.join_hits);
  visit({kUpdate, "join_max_m", "hits further apart than this are never joined [m]"}, update.join_max_m, 0.0, 10.0);
  visit({kUpdate, "update_distance_m", "the map is updated after this much motion [m] ..."}, update.update_distance_m,
        0.0, 10.0);
  visit({kUpdate, "update_angle_rad", "... or this much turning [rad]"}, update.update_angle_rad, 0.0, 3.2);
}

template <class Visitor>
void VisitLoopParameters(LoopParameters& loops, Visitor&& visit) {
  using enum ParameterGroup;
  visit({kLoops, "loops", "places that the robot comes back to are found, and the map is put right"}, loops.loops);
  visit({kLoops, "local_map_m", "what lies further away along the path and its loops is not matched [m]"},
        loops.local_map_m, 5.0, 1000.0);
  visit({kLoops, "loop_lag", "keyframes until what one has brought takes effect"}, loops.lag, 1, 1000);
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
