#pragma once

#include <cstddef>

#include "common/graph/pose_graph.hpp"
#include "common/match/guess/guess_covariance.hpp"

namespace crsm {

/// All that the pose graph and the search for loops take for granted. Tests and studies vary them; users do not.
/// Lengths along the path, unless said otherwise. Where no source is given, a value was chosen on aces, intel,
/// simulated campuses, sim:rooms, sim:hall and exp3, and checked on fr079, killian and other seeds of the campuses.
struct GraphConstants {
  /// How well motions and loops are known, and how poses are found that agree with them.
  struct Edges {
    MotionSigma step{0.003, 0.003, 0.0005};  ///< of a match, besides what its walls leave open: how it was drawn
    double walls = 0.5;                      ///< share of that: a scan is matched to what many before it have drawn
    double uneven = 0.4;     ///< share of a way along a degenerate direction, by which the velocity model errs
    double normals = 0.004;  ///< share of what walls tell across a degenerate direction, that the noise of their
                             ///< normals seems to tell along it
    double across_lost = 10.0;  ///< over lost scans so many times as much
    /// Matches in a row err alike: to loops a chain of them gives way as if each variance were so many times as large.
    double correlated = 2.0;
    MotionSigma proximity{0.06, 0.06, 0.006};
    /// A loop is matched on a map whose own parts have drifted.
    MotionSigma loop{0.1, 0.1, 0.01};
    /// Over a break nobody knows anything. It keeps components that hang on nothing from drifting while others are
    /// solved.
    MotionSigma across_break{100.0, 100.0, 10.0};
    /// A loop's squared error, in standard deviations, above which the others contradict it: six of them.
    double contradicted = 36.0;
    /// [m] and [rad]: poses that an optimisation moves by less stay where they are, up to the first that moves by more.
    double hardly = 1e-6;
    OptimisationConstants optimisation = {};
  };

  /// What is put together to search in, and what for.
  struct Submaps {
    double reach_m = 12.0;           ///< to either side of the middle
    double recent_m = 8.0;           ///< what was seen there is looked for
    double farthest_point_m = 15.0;  ///< from the laser
    double square_m = 0.1;           ///< one point of each is looked for ...
    int most_points = 300;           ///< ... and so many in all
    int fewest_points = 100;         ///< less is no place to be found by
    double cell_m = 0.05;
    double optimum_rad = 0.02;     ///< first step of the climb to the pose of a loop
    double least_agreement = 0.2;  ///< of the newest scan's rays. Of 118 right loops the lowest two had 0.25 and 0.30
    double long_ago_m = 25.0;      ///< what is nearer is in every map that is matched against
    double rival_share = 0.9;      ///< of the best score: corridors are alike every few metres
    double same_place_m = 0.6;     ///< as the crow flies; what is further away is another place
  };

  /// How far poses may have drifted apart over a way: their covariance grows with it.
  struct DriftModel {
    double m_per_m;
    double rad_per_m;
    double least_m = 1.0;
    double least_rad = 0.1;
    double most_m = 15.0;
    double most_rad = 0.6;
  };

  /// Loops within a component.
  struct Loops {
    DriftModel usual{0.005, 0.00015};
    DriftModel largest{0.02, 0.0006};  ///< with a slip in a corridor
    double least_score = 0.55;
    int most_evaluations = 60'000;
    /// So far poses may have drifted apart where the way along the graph is that long; with DriftModel::most_m it goes
    /// by the way driven, which is longer.
    double farthest_m = 40.0;
    double passing_m = 2.0;       ///< from one path to the other, where they meet
    double known_m = 2.5;         ///< from a keyframe where the graph vouches for the place
    double surely_far = 0.5;      ///< of what is too far: loops have hardly made the path twice as long
    double agreeing_m = 12.0;     ///< a way through the graph so much longer ...
    double agreeing_times = 2.0;  ///< ... than so many times as the crow flies: the chain may be bent
    double every_m = 1.0;
    double thoroughly_every_m = 5.0;
    double least_apart_m = 3.0;  ///< of two findings: what is nearer saw mostly the same
    double agree_m = 0.3;        ///< two findings
    double agree_rad = 0.04;
    double remembered_m = 20.0;  ///< a finding that waits for another
    double waits = 0.5;  ///< a loop that differs by so little of its standard deviations from the graph waits ...
    double waits_growth = 0.01;  ///< ... until the graph has so much more keyframes, as a share ...
    int waits_from = 2000;       ///< ... if it has so many: a smaller one is solved in some milliseconds
  };

  /// Whether the robot is where the matches say.
  struct Check {
    double fine_score = 0.6;
    double near_m = 0.3;  ///< window in which it fits ...
    double near_rad = 0.03;
    double nearby_m = 2.5;  ///< ... and the one in which nothing else does
    double nearby_rad = 0.1;
    int nearby_evaluations = 5000;  ///< a place that takes longer is like others
    double far_m = 6.0;             ///< window where it does not fit
    double far_rad = 0.2;
  };

  /// Between components. Chosen on fr-clinic and carried drives in sim:demo (seeds 1 to 12), checked on other seeds,
  /// sim:rooms, sim:twins and sim:symmetric.
  struct Joins {
    double cell_m = 0.1;
    double seen_m = 20.0;           ///< of a ray, from the laser: there nothing stands
    double shorter_m = 0.2;         ///< so far before its hit
    double least_length_m = 2.0;    ///< of a trajectory; a hand before the laser makes one of a scan
    double reach_m = 8.0;           ///< of the window around the middle of a submap
    double least_score = 0.5;       ///< of 106 right places none scored less than 0.57; one wrong one more, 0.78
    int most_evaluations = 30'000;  ///< a submap that takes longer is clutter, where anything fits
    int num_turns = 24;  ///< degrees of 180 that the lines of both agree best at; right ones of fr-clinic were among 22
    std::size_t most_drawn = 256;  ///< submaps that are kept, about 0.3 MB each, and searched at a time
    double turn_near_m = 40.0;  ///< of a place that was found before, along the path: a submap that is searched always
    double every_m = 3.0;
    double soon_every_m = 1.5;   ///< soon after a break
    double least_apart_m = 8.0;  ///< of two findings: they share nothing of what was seen (Submaps::recent_m)
    double few_m = 50.0;  ///< of way in other components: in so little another place hardly looks the same, and ...
    double least_apart_of_few_m = 3.0;  ///< ... this is enough
    double remembered_m = 100.0;        ///< a finding that waits for another
    double least_away_m = 2.0;  ///< of two findings, as the crow flies: a robot that turns on the spot sees the same

    // What was joined is checked for some metres, while the graph vouches for where the robot is.
    double checked_m = 50.0;
    double checked_within_m = 5.0;    ///< of a keyframe of another trajectory
    double contradicted_share = 0.3;  ///< right ones: 0.29 at most, in killian; wrong ones: 0.35 at most

    // Nearby: where the robot is soon after a break, if it went on as before.
    double soon_m = 25.0;
    double back_m = 40.0;              ///< to the end of an earlier trajectory
    double before_m = 8.0;             ///< of its end: the middle of a submap
    double nearby_m = kGuessWindow.m;  ///< the window, and how it grows with the time between ...
    double nearby_rad = kGuessWindow.rad;
    double m_per_s = kGuessWindow.m_per_s;
    double rad_per_s = kGuessWindow.rad_per_s;
    double nearby_most_m = kGuessWindow.most_m;  ///< ... up to
    double nearby_most_rad = 0.8;
    double bridged_m = 0.3;  ///< ... or, where wheels bridge the break, so much and some standard deviations
    double bridged_rad = 0.05;
    double bridged_sigmas = 5.0;
    double nearby_point_m = 30.0;  ///< farthest, from the laser: outdoors little is near
    double nearby_score = 0.2;
    int nearby_evaluations = 60'000;
    double nearby_apart_m = 1.4;  ///< of two findings
    double sure_score = 0.75;     ///< of a finding that needs no second one, soon after a break of ...
    double short_break_s = 5.0;  ///< ... less than this: in more, the robot may be anywhere, and no other place may fit
  };

  /// The parts of a map that hang together.
  struct Pieces {
    double least_way_m = 3.0;  ///< a smaller piece gets no map of its own: a turn on the spot, say
  };

  /// The map that scans are matched to.
  struct LocalMap {
    double period_m = 20.0;       ///< of looks which keyframes belong there
    double bearable_reach = 3.0;  ///< times its reach along the graph: what lies within may stay ...
    double far_away = 0.5;        ///< ... if it is so many times its reach away as the crow flies
    double constraint_m = 2.5;    ///< of a proximity constraint: from a keyframe of long ago to the new one
    double place_m = 1.5;         ///< of those of long ago the newest of each place ...
    double direction_rad = 0.35;  ///< ... and direction is drawn
    int missing_at_once = 2;      ///< keyframes of long ago that are drawn with a new one, where the robot comes back
  };

  /// Where the robot has been so often that a scan tells little that is new. There fewer are drawn, so that a map grows
  /// with the building, and hardly with the time. By the place and direction of LocalMap.
  struct KnownGround {
    int keyframes = 20;           ///< of one place and direction: four passes, say
    double every_m = 10.0;        ///< so far from the last keyframe the next one is drawn all the same
    double least_fitness = 0.55;  ///< of a scan that need not be drawn: in a lower one something may have changed
  };

  /// How far off a map may be: no factor, the motions are taken to be as uncertain as Edges says.
  struct MapError {
    int samples = 60;
    double quantile = 0.95;   ///< of the samples
    double least_m = 0.05;    ///< a cell: no map is better
    double way_back_m = 0.5;  ///< a map that may be further off is asked which drive would tell most
    double slip_m = 0.3;      ///< of one step: less is drift
  };

  int lag = 6;          ///< keyframes until what a loop has brought is taken up: so long it is searched ...
  int drawing_lag = 4;  ///< ... and so many more until it takes effect: so long the map is drawn anew beside
  Edges edges = {};
  Submaps submaps = {};
  Loops loops = {};
  Check check = {};
  Joins joins = {};
  LocalMap local_map = {};
  MapError map_error = {};
  KnownGround known_ground = {};
};

}  // namespace crsm
