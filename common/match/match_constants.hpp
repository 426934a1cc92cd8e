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
    double mutation_m = 0.1;    ///< mutation bound, +- in x and y
    double mutation_rad = 0.1;  ///< ... and in yaw
    int restart_draws = 6;      ///< random poses, on the best of which a climb begins again
    int min_climbs = 3;         ///< one alone may end on an optimum beside the highest, and be good enough there
    double shrink = 0.9;        ///< of the bounds, for each child that fails to beat its parent
    double smallest = 0.02;     ///< share of the bounds at which a climb ends: 2 mm, and as many milliradians
    double hopeless_at = 0.5;   ///< share of the bounds at which a climb gives up ...
    double hopeless = 0.3;      ///< ... that is this far below the highest fitness
    double highest = 1.0;       ///< fitness at which any search ends
  };

  /// Where nothing fits near the initial guess.
  struct WideSearch {
    int num_evaluations = 10000;
    double window_m = 0.6;             ///< +- in x and y
    double window_rad = 1.2;           ///< +- in yaw
    int draws = 30;                    ///< most poses in so wide a window are not worth a climb
    std::int64_t lost_scans_min = 2;   ///< the window grows from here ...
    std::int64_t lost_scans_max = 12;  ///< ... to here: 3.5 times as wide, 2 m to either side
    double growth = 0.25;              ///< of the window, with each
    double growth_unsteady = 0.5;      ///< of the window, where the motion is not steady
    double agreement_min = 0.5;        ///< of rays, in a window that has grown
    double far_gain = 1.1;             ///< by which a place of the far search must fit better
  };

  /// What holds the pose at its initial guess.
  struct MotionPrior {
    double per_m2 = 0.5;             ///< fitness lost per squared distance
    double degenerate_per_m2 = 7.0;  ///< ... along a degenerate direction, at least
    double degenerate_max_per_m2 = 40.0;
    double degenerate_per_m = 0.08;  ///< divided by the error of motions so far: who drives evenly is held more
    double degeneracy_min = 0.2;     ///< below, the walls tell more than the prior
    double chance_gain = 0.05;       ///< of fitness along a bare corridor: three sigma of the wheels outweigh it
    double wheels_sigma_min_m = 0.01;
    double wheels_sigma_max_m = 0.03;
    double wheels_near_m = 0.3;  ///< reliable wheels hold where the search ended so near to them
    double steady_s = 0.3;       ///< after the last match: longer, and a robot becomes faster or slower
  };

  /// The last climb, with all rays.
  struct FinalClimb {
    double spacing_max_m = 0.3;           ///< weight of a ray: the distance to its neighbours, at most this
    double optimum_rad = 0.02;            ///< half the width of the optimum in whose middle the yaw is
    double look_along_m = 1.0;            ///< along a degenerate direction
    double look_gain = 0.02;              ///< least gain of fitness there ...
    double look_gain_steady = 0.03;       ///< ... and so much more where the motion is steady
    double look_cost_wheels_per_m = 0.1;  ///< wheels slip little by little
    double known_share_min = 0.8;         ///< of the weight of all rays: fewer do not say where the laser is
  };

  /// When wheels are asked, and when they contradict a match.
  struct Wheels {
    double preferred_gain = 1.2;     ///< smaller ratios of fitness are within noise
    double contradict_sigmas = 5.0;  ///< and besides what a match may be off:
    double match_error_m = 0.1;
    double match_error_rad = 0.05;
    double proven = 0.75;    ///< fitness that proves a match which they contradict
    double rival = 0.85;     ///< fitness near the wheels' pose, of that of the match: places are alike
    double stands_m = 0.05;  ///< wheels that move less stand ...
    double stands_rad = 0.05;
    double lifted_s = 2.0;  ///< ... and nobody lifts a robot faster
  };

  /// Which fitness is enough, and which is too little.
  struct Acceptance {
    double good = 0.95;                ///< the search stops here
    double lost = 0.7;                 ///< below, the wide window is searched, and then the scan is lost
    double relaxation = 0.9;           ///< of that, after each consecutive loss: the scene may have changed ...
    std::int64_t relaxations_max = 4;  ///< ... so many times. On a finished map it did not: the robot was carried
    double explored_min = 0.8;         ///< share of the hits that must fit in a scan that looks into the unknown
    double explored_min_near = 0.5;    ///< ... near the initial guess, where a short-sighted robot drives on
  };

  /// On a finished map.
  struct FinishedMap {
    /// Until a scan is found. Scans of the mapped building have 0.65 to 0.8 on intel, aces, fr079 and simulated worlds.
    double baseline_fitness = 0.6;
    /// What is expected at least, or a place that was found wrongly would lower it. A `lost` of 0.7 of it asks for
    /// 0.53, which one scan of the building in twenty has not; at wrong places scans have 0.2 to 0.5.
    double baseline_fitness_min = 0.75;
    double followed_fitness = 0.5;       ///< a robot is followed from here on: hardly ever reached at wrong places
    std::int64_t followed_lost_max = 5;  ///< ... until so many scans are lost
    std::int64_t search_every = 10;  ///< lost scans between searches of the whole map: people walk on after a second
    double near_m = 0.3;             ///< that a followed robot may have moved between scans
    double near_rad = 0.25;
  };

  /// How the motion goes on. A mean of some motions: along a corridor no single one is known well.
  struct Prediction {
    std::size_t motions = 4;
    std::size_t motions_degenerate = 9;  ///< an error of one motion would grow until the robot seemed to stand
    std::int64_t oldest_us = 2'000'000;
    std::size_t lost_scans_max = 5;  ///< after a second the robot does something else
    double onward_max_s = 6.0;
    double onward_turn = 0.5;  ///< turns end sooner than drives
  };

  /// When a trajectory ends.
  struct Break {
    int lost_scans_max = 3;          ///< in a row
    std::size_t hardly_matched = 3;  ///< scans: a trajectory with fewer is no loss, one lost scan ends it
    double gap_max_s = 8.0;          ///< between scans; only a robot that stood still goes on after it ...
    double gap_periods = 8.0;        ///< ... and so many periods: a logger may take a scan a metre
    double stood_still_m = 0.3;
    double stood_still_rad = 0.2;
    double stood_still_fitness = 0.9;
    double found_again_fitness = 0.6;  ///< in a wide window something fits by chance
    std::size_t fewest_rays = 20;      ///< less is no place to begin a map at
    /// A scan that fits worse than this is asked whether the map contradicts it: a robot that was carried stands where
    /// something fits by chance.
    double suspect_fitness = 0.75;
    /// No scan of intel, fr079, aces and killian is so bad: one in a niche of aces has 0.416. Of six robots that were
    /// carried in aces and killian to where a scan fits by chance, four had more than 0.38.
    double contradiction_max = 0.42;
  };

  Search search = {};
  WideSearch wide_search = {};
  MotionPrior prior = {};
  FinalClimb final_climb = {};
  Wheels wheels = {};
  Acceptance acceptance = {};
  FinishedMap finished_map = {};
  Prediction prediction = {};
  Break breaks = {};
};

}  // namespace crsm
