#pragma once

#include <cstddef>
#include <cstdint>

namespace crsm {

/// All that the matcher takes for granted. Tests and studies vary them; users do not. Shares of a fitness are of the
/// baseline fitness, that of the last scans, unless said otherwise. Where no source is given, a value was chosen on
/// aces, intel and simulated buildings, and checked on fr079, killian and other seeds.
struct MatchConstants {
  /// Random restart hill climbing, section 5.3.
  struct Search {
    int num_evaluations = 700;  ///< N_HC
    double window_m = 0.4;      ///< re-initialisation bound, +- in x and y
    double window_rad = 0.25;   ///< ... and in yaw
    double mutation = 0.1;      ///< mutation bound, +- in x and y [m], and in yaw [rad]
    int restart_draws = 6;      ///< random poses, on the best of which a climb begins again
    double shrink = 0.9;        ///< of the bounds, for each child that fails to beat its parent
    double smallest = 0.02;     ///< share of the bounds at which a climb ends: 2 mm, and as many milliradians
  };

  /// What is another place: so far away.
  struct OtherPlace {
    double m = 0.6;
    double rad = 0.2;
  };

  /// Where a scan was taken, if nothing near the initial guess fits or nothing is known: branch and bound.
  struct MapSearch {
    double least_m = 0.6;  ///< of the window, to either side
    double least_rad = 1.2;
    double faster_m_s = 0.4;  ///< that a robot becomes in a second
    double faster_rad_s = 0.6;
    double faster_most_m = 1.0;  ///< further, becoming faster does not bring it
    double most_m = 3.0;         ///< the largest window
    double most_rad = 1.6;
    double close_s = 0.5;  ///< between scans: where they follow closer, what fits near the guess is the place
    double cell_m = 0.1;
    double most_reach_cells = 1000.0;  ///< of a whole map, to either side: on a larger one cells are larger
    double farthest_m = 15.0;          ///< of a hit, from the laser
    std::ptrdiff_t most_points = 180;  ///< hits, evenly spread
    double least_score = 0.2;          ///< of the hits: a scan may look into the unknown
    double rival_share = 0.9;          ///< of the best score: as good as this, another place is looked at closely
    std::size_t most_places = 50;
    int plateau_steps = 2;  ///< to either side: all that lies on the same coarse cells
    int halvings = 4;       ///< of the steps of the climb there
    int most_evaluations = 200'000;
    int most_whole_evaluations = 8'000'000;  ///< on a whole map: about a second
    double runner_up_share = 0.75;  ///< of the best score: with more the other place may be it. Rooms may be alike
    /// As of ScorePlace: less is no place where a scan was found, when nothing was known. Of 780 searches for scans in
    /// maps of other buildings one was convincing; of 660 in maps of their own 7 % of those that found the place scored
    /// less, and none was convincing elsewhere.
    double least_found_score = 0.45;
    OtherPlace other_place = {};
  };

  /// What a map says of the rays of a scan.
  struct Census {
    double tolerance_m = 0.15;   ///< from the end of a ray to what stands there; at least a cell
    double before_end_m = 0.5;   ///< there a ray passes through nothing: a wall that is seen flat it may touch
    int least_cells = 2;         ///< that it passes through: a single one may be an error of drawing
    double most_steps = 4000.0;  ///< along a ray: a longer one takes longer steps
  };

  /// Which rays a map tells anything of, along an axis.
  struct KnownRays {
    int behind_wall_cells = 3;  ///< at most, from the wall to a place that is just behind it
    int beside_axis_cells = 2;  ///< of what stands across the axis, to either side: most of these five cells
  };

  /// What holds the pose at its initial guess.
  struct MotionPrior {
    double per_m2 = 0.5;             ///< fitness lost per squared distance
    double degeneracy_min = 0.2;     ///< below, the walls tell more than what is guessed
    double degenerate_per_m2 = 7.0;  ///< ... along a degenerate direction, at least
    double degenerate_max_per_m2 = 40.0;
    double degenerate_per_m = 0.08;  ///< divided by the error of motions so far: who drives evenly is held more
    /// The same of the wheels, per squared standard deviation: chance gains nearly 0.05 in a bare corridor, which three
    /// of them outweigh.
    double wheels_per_sigma2 = 0.0056;
    double wheels_near_m = 0.3;  ///< reliable wheels hold where the search ended so near to them
    double steady_s = 0.3;       ///< after the last match: longer, and a robot becomes faster or slower
  };

  /// The climb to the top of an optimum, to a fraction of a cell.
  struct Optimum {
    double longest_step_rad = 0.01;  ///< no further at a time, and no further than a cell
    double shortest_step = 0.01;     ///< of these: a shorter one is the last
    double least_damping = 0.01;     ///< of the steepest slope's change
    int most_passes = 20;
    int widths = 4;            ///< that say where the middle of the yaw is
    double least_fall = 0.02;  ///< of fitness: an optimum as flat as this has no middle
  };

  /// How well a scan tells where it was taken.
  struct Uncertainty {
    double near_cells = 2.0;  ///< hits this close lie on one surface
    /// Hits further apart tell no direction: those of a wall 8 m away at one beam a degree and 10 degrees from its
    /// plane.
    double largest_surface_gap_m = 0.8;
    double chord_m = 0.4;           ///< a shorter piece of wall does not tell its direction: hits are a centimetre off
    int chord_gaps_min = 2;         ///< between its hits: two hits alone tell no direction
    double post_free_share = 0.85;  ///< of what is as far as a chord around a post; along a wall it is half
    double sigma_cells = 1.0;       ///< of one ray, as neighbouring rays err alike, and of the map
    double map_rad = 0.005;
    double unknown_m = 1.0;  ///< where nothing is told: as far as one gets between scans
    double unknown_rad = 0.3;
    /// An axis is degenerate where less is told than by a few rays, or by that share of all rays which the noise of the
    /// normals alone makes of a straight wall.
    double few_rays = 3.0;
    double noise_share = 0.02;
  };

  /// How far a robot was found from where it was guessed to be after lost scans or a gap: to either side, and how that
  /// grows with the time between. It is what is searched there, up to a limit, for the place where a trajectory begins.
  /// Chosen on fr-clinic and carried drives in sim:demo.
  struct GuessWindow {
    double m = 0.7;
    double rad = 0.2;
    double m_per_s = 0.35;
    double rad_per_s = 0.1;
    double most_m = 4.0;       ///< the limit
    double sigma_share = 0.5;  ///< of the window: a standard deviation
  };

  /// The last climb, with all rays.
  struct FinalClimb {
    double spacing_max_m = 0.3;         ///< weight of a ray: the distance to its neighbours, at most this
    double optimum_rad = 0.02;          ///< half the width of the optimum in whose middle the yaw is
    double look_along_first_m = 1.0;    ///< along a degenerate direction, where no motion is known yet
    double look_same_rays_cells = 4.0;  ///< so far on, about the same rays are known
    double look_gain = 0.04;            ///< least gain of fitness there: in a bare corridor chance gains nearly 0.05
    double known_share_min = 0.8;       ///< of the weight of all rays: fewer do not say where the laser is
  };

  /// When wheels are asked, and when they contradict a match.
  struct Wheels {
    double match_error_m = 0.1;  ///< what a match may be off, besides what is a slip of the wheels
    double match_error_rad = 0.05;
    double proven = 0.75;    ///< fitness that proves a match which they contradict
    double stands_m = 0.05;  ///< wheels that move less, turns at 1 m from the laser included, stand ...
    double lifted_s = 2.0;   ///< ... and nobody lifts a robot faster
  };

  /// What the wheels are worth, learned from matched motions.
  struct WheelModel {
    // What is believed before anything was learned, and how strongly: as if so many steps had said so.
    double prior_scale = 0.2;    ///< standard deviations: of the scale, and of the mounting [rad] ...
    double prior_lever_m = 0.3;  ///< ... of the laser's place ...
    double prior_turn = 0.1;     ///< ... of the turn's scale
    double prior_steps = 5.0;    ///< of the noise, which is:
    double prior_noise = 0.1;    ///< standard deviation of a way after a metre [m], and of a turn after a radian [rad]
    double prior_cross_noise = 0.05;  ///< ... of a way after a radian of turning, and of the heading after a metre

    double step_m = 0.5;         ///< a step ends that far from where it began, or as far turned, at 1 m from the laser
    double forget = 0.995;       ///< with each step: a hundred metres count
    double huber = 2.0;          ///< standard deviations, from which on a residual counts less
    double most_residual = 4.0;  ///< ... as which a larger one counts
    double slip = 5.0;           ///< ... from which on it is a slip
    double follow = 0.05;        ///< share of the newest motion in the mean errors

    double fastest = 5.0;  ///< that a robot drives [m/s] or turns [rad/s]: further, its odometry jumps
    double jump_m = 1.0;   ///< less is no jump in any time: stamps are not exact
    double jump_rad = 1.5;

    double least_sigma = 0.001;   ///< standard deviation of any motion [m and rad]
    double most_noise_m = 0.12;   ///< after a metre: more, and they are no help ...
    double most_noise_rad = 0.2;  ///< ... and after a radian

    std::int64_t few_steps = 5;    ///< learned from: with fewer nothing is said
    std::int64_t many_steps = 20;  ///< with these they are reliable
  };

  /// What is learned of how the robot drives.
  struct Tracking {
    double first_motion_error_m = 0.02;  ///< of an uneven one
    double follow = 0.01;                ///< share of the newest motion in the mean error
    double match_m = 0.01;               ///< what a good match may be off: less is no motion

    friend bool operator==(const Tracking&, const Tracking&) = default;
  };

  /// Scans whose beams were measured one after the other.
  struct Sweep {
    double lever_m = 5.0;  ///< from the laser: there turns are counted as ways
    int most_matches = 4;
    double fastest_turn_rad_s = 5.0;
  };

  /// Which fitness is enough, and which is too little.
  struct Acceptance {
    double good = 0.95;              ///< the search stops here
    double lost = 0.7;               ///< below, the wide window is searched, and then the scan is lost
    double relaxation = 0.9;         ///< of that, after each consecutive loss up to `patience`: the scene may have
                                     ///< changed. On a finished map it did not: the robot was carried
    double explored_min = 0.8;       ///< share of the hits that must fit in a scan that looks into the unknown
    double explored_min_near = 0.5;  ///< ... near the initial guess, where a short-sighted robot drives on
    std::int64_t patience = 5;  ///< lost scans in a row, after which nobody knows where the robot is or how it moves
  };

  /// On a finished map.
  struct FinishedMap {
    /// Until a scan is found. Scans of the mapped building have 0.65 to 0.8 on intel, aces, fr079 and simulated worlds.
    double baseline_fitness = 0.6;
    /// What is expected at least, or a place that was found wrongly would lower it. A `lost` of 0.7 of it asks for
    /// 0.53, which one scan of the building in twenty has not; at wrong places scans have 0.2 to 0.5.
    double baseline_fitness_min = 0.75;
    double followed_fitness = 0.5;   ///< a robot is followed from here on: hardly ever reached at wrong places
    std::int64_t search_every = 10;  ///< lost scans between searches of the whole map: people walk on after a second
    /// A score, as of ScorePlace: less, and a scan is lost although it is near the place of the last one on a finished
    /// map. Where scans of the building are followed, 1 in 20 scores less than 0.42 on intel, 0.38 on aces and 0.26 on
    /// fr079, the last ones where the robot looks into rooms that are not on the map. Scans that were followed at wrong
    /// places scored up to 0.18, half of them less than 0.04.
    double least_tracked_score = 0.25;
    /// The same where the last ten scans that were found fit so well that the place is right: on intel people and doors
    /// bring scans of the mapping itself down to 0.1.
    double least_followed_score = 0.08;
  };

  /// How the motion goes on. A mean of some motions: along a corridor no single one is known well.
  struct Prediction {
    std::size_t motions = 4;
    std::int64_t oldest_us = 2'000'000;

    friend bool operator==(const Prediction&, const Prediction&) = default;
  };

  /// How much of what was seen lies on straight lines, by their direction.
  struct LineSpectrum {
    double apart_m = 0.2;  ///< two lines
    int lines = 400;       ///< so many of each direction, half of them to either side of the middle
  };

  /// When a trajectory ends.
  struct Break {
    int lost_scans_max = 3;    ///< in a row
    double gap_max_s = 8.0;    ///< between scans; only a robot that stood still goes on after it ...
    double gap_periods = 8.0;  ///< ... and so many periods: a logger may take a scan a metre
    double stood_still_fitness = 0.9;
    double found_again_fitness = 0.6;  ///< in a wide window something fits by chance
    std::ptrdiff_t fewest_rays = 20;   ///< less is no place to begin a map at, and cannot be searched for
  };

  Search search = {};
  MapSearch map_search = {};
  Census census = {};
  KnownRays known_rays = {};
  MotionPrior prior = {};
  Optimum optimum = {};
  Uncertainty uncertainty = {};
  GuessWindow guess_window = {};
  FinalClimb final_climb = {};
  Wheels wheels = {};
  WheelModel wheel_model = {};
  Tracking tracking = {};
  Sweep sweep = {};
  Acceptance acceptance = {};
  FinishedMap finished_map = {};
  Prediction prediction = {};
  LineSpectrum line_spectrum = {};
  Break breaks = {};
};

}  // namespace crsm
