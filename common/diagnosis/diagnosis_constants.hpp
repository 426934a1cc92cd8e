#pragma once

#include <cstddef>
#include <cstdint>

#include "common/match/match_constants.hpp"
#include "common/math/trigonometry.hpp"

namespace crsm {

/// All that the diagnosis takes for granted, by subject. Tests and studies vary it; users do not. For the data on which
/// the values were chosen and checked see Judge. Shares are in [0, 1].
struct DiagnosisConstants {
  /// Whether scans contradict each other where the robot was twice.
  struct SelfContradiction {
    double apart_m = 0.4;  ///< of scans that are compared: of those that are less apart one is taken
    double apart_rad = 0.4;
    double same_place_m = 1.0;         ///< two scans within it are of one place ...
    double long_apart_m = 8.0;         ///< ... long apart, if so far along the path
    std::size_t most_pairs = 1000;     ///< that are compared
    std::ptrdiff_t most_hits = 90;     ///< of a scan
    int least_seen = 10;               ///< hits: a scan that sees fewer of another's tells nothing
    double beam_gap = 1.6;             ///< of the usual step between beams: a beam between them met nothing
    double nearest_m = 0.2;            ///< hits that are nearer tell nothing
    double tolerance_m = 0.1;          ///< of ranges ...
    double tolerance_per_m = 0.02;     ///< ... and so much more with each metre of them
    double contradicting_share = 0.3;  ///< of the hits, above which two scans contradict each other
    double square_m = 2.0;             ///< side of the squares, of which the worst is found ...
    int square_looks_min = 8;          ///< ... among those with so many looks
  };

  /// What is gathered of a run.
  struct Statistics {
    std::size_t most_sampled = 2000;  ///< scans in the sample ...
    std::size_t most_rays = 720;      ///< ... and rays of each
    // Of those, what is asked for agreement.
    std::size_t most_asked = 200;                      ///< scans ...
    std::size_t most_rays_asked = 60;                  ///< ... and rays of each
    std::size_t least_asked = 20;                      ///< fewer scans tell nothing
    double far_m = MatchConstants::Search{}.window_m;  ///< a step beyond the window of the search is found by luck
    double far_rad = MatchConstants::Search{}.window_rad;
    double jump_m = 3.0;            ///< a step longer than this, and ...
    double jump_m_s = 10.0;         ///< ... faster, is of no robot
    double path_step_m = 0.2;       ///< of the path: longer than what a robot that stands seems to move
    double least_turns_rad2 = 0.1;  ///< that odometry is judged by: thirty turns of 0.06 rad
    double least_ways_m2 = 0.3;     ///< ... and thirty steps of 0.1 m
    SelfContradiction contradiction = {};
  };

  /// Whether a map is to be trusted. With each threshold: the extremes of the maps that are right, and of those that
  /// are wrong, in our logs and worlds.
  struct Verdict {
    std::int64_t few_scans = 20;  ///< fewer tell nothing

    /// Right: 0.58 (aces) to 0.98, outdoors 0.49. Wrong by angles, ranges, order or noise: 0.02 to 0.5, a few 0.8.
    double least_agreement = 0.45;
    double fair_agreement = 0.5;

    /// Right: 0.63 (exp3) to 0.84. Scans that do not belong together: 0.21 to 0.5, a few 0.58.
    double least_fitness = 0.5;
    double fair_fitness = 0.6;

    /// Right: 0 to 0.01. Every 20th scan: 0.02 to 0.5; what else loses the track: 0.06 to 0.8.
    double most_lost = 0.05;            ///< also of scans without rays
    double most_lost_in_motion = 0.02;  ///< where the laser also moves far between scans
    double few_far_steps = 0.03;        ///< right, at full rate: 0 to 0.006, and 0.13 in hall, with nothing lost
    double mostly_blind = 0.5;          ///< of the scans without rays: the map is bad, not doubtful

    /// Right: 0 to 0.18, 0.59 of a laser with a reach of 4 m. Ranges of a tenth: 0.7 to 1.
    double most_degenerate = 0.8;

    /// Right: 0 to 0.13 (hall), turns of 3 rad/s 0.17 if they are deskewed, on every 5th scan up to 0.98. Wrong: 0.17
    /// to 0.95.
    double many_far_steps = 0.15;

    /// Scans in a row. Right: 4. Tracks that were found again elsewhere: 10 to 770.
    std::int64_t long_lost = 20;

    /// Of the matched scans. What is not on the map is missing: a room, say. Right: 1.
    double least_on_largest = 0.98;
    double least_of_all = 0.5;  ///< scans that measured anything: with less of what was seen it is no map of it

    /// Scans of about the same place, long apart along the path. Right by the mean of their errors: 0.041 at most, but
    /// for killian at 8 m with odometry (0.076), aces without loops (0.48) and the flat by 70 and 90 degrees (0.41).
    /// Wrong: up to 1, but also as little as 0.014 (aces at 8 m).
    std::int64_t few_looks = 20;
    double most_contradict = 0.05;
    std::int64_t very_few_looks = 10;
    double most_of_few_contradict = 0.2;

    /// A laser that stands seems to move by 0.055 m and 0.023 rad (an RPLidar in a hall).
    double stands_within_m = 0.15;
    double stands_within_rad = 0.1;

    double most_left_out = 0.1;  ///< of the recording: that much may be a room

    double opposite = -0.5;  ///< of the correlation of two motions: turns that are mirrored ...
    double across = 0.5;     ///< ... and ways in different directions

    // On a finished map.
    double most_lost_on_map = 0.1;
    double mostly_lost_on_map = 0.5;  ///< the poses are bad, not doubtful

    // How far off a map may be and yet be of use: this, or so much of its size.
    double far_off_m = 1.0;
    double far_off_share = 0.01;
    double off_place_m = 0.3;  ///< less is said without the place where it is most likely
  };

  /// By which sweep turning scans fit best.
  struct SweepStudy {
    std::size_t num_scans = 1500;      ///< that may be looked at
    double turning_rad = 0.02;         ///< in a sweep: a cell at 2.5 m
    int enough_turning = 120;          ///< scans, with those that are lost
    int few_turning = 12;              ///< fewer prove nothing
    double better_fitness_min = 0.01;  ///< by which one sweep is better than another ...
    double better_sigmas = 3.0;        ///< ... and that is no chance
    double longest_period_s = 1.0;     ///< of scans whose sweep is guessed, and ...
    double narrowest_view_rad = 3.5;   ///< ... their view: a SICK LMS, which sees half a turn, takes 0.007 s for it
    double shortest_share = 0.02;      ///< of the period: a likely sweep
    double longest_share = 1.05;
    double alike_share = 0.25;  ///< sweeps that differ by less are tried as one
  };

  /// The ranges that stand for "no return".
  struct RangeStudy {
    /// Of the largest range: within it lie all of them. A SICK LMS 200 has the values 8183 to 8191 for the reasons why
    /// nothing was measured, in millimetres or centimetres.
    double pile_share = 0.001;
    double many_beams = 0.05;  ///< of all that were measured
    double all_over = 0.2;     ///< of the view: a wall straight ahead of a robot that stands is narrower

    /// Where so many different beams have one range within so much of the largest, those are no hits.
    double pile_m = 0.1;
    std::size_t pile_beams = 10;
  };

  /// Whether a laser is set up wrongly.
  struct LaserJudge {
    int window_steps = 20;          ///< last steps of the clock, 64 at most
    int enough = 10;                ///< of them, or scans in a row: a second of a slow laser
    int steps_of_pace = 50;         ///< of the clock, which tell its unit
    int looked_at_first = 30;       ///< scans, and then ...
    int looked_at_one_in = 10;      ///< ... one in so many
    std::size_t valid_one_in = 10;  ///< in millimetres no more than one range in so many is one that the laser has
    /// Of the median range. Metres that few lasers reach, and 0.1 m: closer than most walls are.
    float millimetres_median_min = 100.0f;
    float millimetres_median_max = 100'000.0f;  ///< 100 m
  };

  /// Whether scans are mirrored.
  struct Handedness {
    int enough_pairs = 10;                      ///< of scans
    int others_one_in = 5;                      ///< of the pairs at most one in so many tells otherwise
    double least_turn_rad = 4.0 * kPi / 180.0;  ///< between the scans of a pair
    double most_turn_rad = 45.0 * kPi / 180.0;
    int oldest_scans = 10;           ///< ago, the first of a pair
    double clearly = 0.75;           ///< how much better one of the two must fit
    int enough_shared = 30;          ///< directions in which both scans saw something
    float most_difference_m = 0.5f;  ///< what stands free differs by more, and tells no more
  };

  /// What has changed since a map was made. Source: chosen on simulated flats of the seeds 1 to 6, 303, 304 and 404, on
  /// sim:demo, sim:rooms and fr079; checked on twenty other flats.
  struct Changes {
    double step_m = 0.1;  ///< a scan that was taken nearer to the last one, ...
    double step_rad = 0.1;
    double step_s = 1.0;           ///< ... and sooner after it, says nothing more
    int most_asked = 90;           ///< rays of a scan, whether it fits the map, ...
    double least_agreement = 0.7;  ///< ... of those that the map knows; else it was matched to a wrong place
    double place_m = 0.5;          ///< places further apart than this are two, ...
    double place_rad = 0.35;       ///< ... and so are those that look another way by 20 degrees
    double range_sigma_m = 0.02;
    double sigmas = 3.0;            ///< of pose and range, that explain a ray, ...
    double tolerance_cells = 2.0;   ///< ... beside so many cells
    double tolerance_max_m = 0.3;   ///< a ray that is known less well says nothing
    double before_end_m = 0.2;      ///< what lies nearer to a ray's end it has not passed
    double beside_m = 0.3;          ///< along a ray that is moved: as far it may meet the same thing
    int enough_against = 3;         ///< scans that see a cell unchanged, after the last one that saw it changed
    double behind_m = 1.0;          ///< so deep a thing may be that stands again
    int enough_errors = 1;          ///< scans that the map was made from, which contradict it there
    int least_places = 2;           ///< that saw a cell changed, ...
    int least_places_of_thing = 3;  ///< ... and the whole of a thing
    double majority = 2.0;  ///< so many times more scans saw a cell changed than unchanged since the first of them
    int least_scans = 3;
    double apart_m = 0.25;  ///< cells nearer than this are of one thing, which ...
    double least_m = 0.2;   ///< ... is at least so long, ...
    int least_cells = 5;    ///< ... and has so many cells
  };
};

}  // namespace crsm
