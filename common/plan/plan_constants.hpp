#pragma once

namespace crsm {

/// What the making of floor plans takes for granted. Source: chosen on simulated flats of five seeds and on intel;
/// checked on ten other flats and on fr079.
struct PlanConstants {
  /// Of one scan: what may be a piece of a wall.
  struct Stretch {
    double near_m = 0.12;          ///< hits this close are on one surface
    double join_max_m = 0.6;       ///< hits further apart never are
    double bend_max_m = 0.05;      ///< a surface that leaves its chord by more is split there
    double residual_max_m = 0.03;  ///< root mean square of what belongs to one line: five times a laser's noise
    double least_m = 0.25;         ///< shorter ones do not say where a line runs
    int least_hits = 5;
  };
  Stretch stretch = {};

  /// Of a line that many scans saw.
  struct Line {
    double offset_max_m = 0.06;   ///< across it, of what belongs to it: poses are better than that
    double yaw_max_rad = 0.05;    ///< between it and a long stretch
    double end_m = 0.04;          ///< a stretch may turn by so much at its end
    double along_max_m = 2.0;     ///< to the next stretch along it: wider than what hides a wall
    double turn_max_rad = 0.02;   ///< its stretches turn against it by no more on the average; else it is several lines
    double close_m = 0.5;         ///< ... whose stretches are this close along each of them
    double one_face_m = 0.04;     ///< two faces nearer than this are one thin wall
    double double_m = 0.2;        ///< a second face of the same side, so near, is the first one seen with a wrong pose
    double double_share = 0.33;   ///< if no more scans saw it than this share
    int least_scans = 3;          ///< that saw a piece of wall; people were elsewhere in the next one
    double pose_sigma_m = 0.003;  ///< a pose is not better known than this
  };
  Line line = {};

  /// The main directions of a building.
  struct Direction {
    double width_rad = 0.035;  ///< lines this near to it make it up: 2 degrees
    double least_share = 0.2;  ///< of the length of all walls, else it is none
    int most = 3;
    double sigmas = 3.0;            ///< a line is snapped if it is off by no more than these, ...
    double yaw_sigma_rad = 0.0015;  ///< ... none of which is less than this, ...
    double most_rad = 0.06;         ///< ... and by no more than this
  };
  Direction direction = {};

  struct Wall {
    double bin_m = 0.02;          ///< along a line
    double least_m = 1.2;         ///< a shorter one is a wall only beside a door, or between two others
    double jamb_m = 0.08;         ///< ... and has to be this long; or it is this long ...
    double in_line_m = 0.3;       ///< ... and goes on a longer one
    double hole_m = 0.25;         ///< a hole up to this is none, unless rays went through it
    double hidden_m = 2.0;        ///< a hole up to this that no ray went through is hidden by what stands before it
    double free_share = 0.2;      ///< ... but for this share of it
    double before_m = 1.3;        ///< so deep is furniture, and so near to the wall that it hides
    double corner_depth_m = 0.7;  ///< ... or so deep in a corner of the room
    double beside_m = 0.4;        ///< and so much it may be wider than what it hides
    double corner_m = 0.15;       ///< an end this near to another wall ends at it
    double structure_m = 1.8;     ///< what hangs together has to be so long or wide: furniture is not
    int pierced_scans = 3;        ///< a wall through which so many scans looked has gone, or was none
    double pierced_share = 1.5;   ///< times those that saw it
  };
  Wall wall = {};

  struct Door {
    double least_m = 0.6;
    double most_m = 1.5;
    double free_share = 0.8;  ///< of the way through it
    double through_m = 0.15;  ///< how far before and behind it is looked
  };
  Door door = {};

  struct Room {
    double least_m2 = 1.5;
    double closed_share = 0.6;  ///< of its contour that is wall or door
    double gap_m = 0.6;         ///< a smaller gap between walls in line closes a room, too
    double touch_m = 0.4;       ///< ... and so does one between the end of a wall and another wall
    double own_share = 0.15;    ///< of the contour of what nobody saw in it: else it is no part of the room
    int most_cells = 20'000'000;
    double cell_m = 0.02;  ///< or more, where that would be too many
  };
  Room room = {};

  /// Where rays went.
  struct Space {
    double cell_m = 0.05;
    double before_hit_m = 0.03;  ///< a ray is known to be free up to this before its end
    double deep_m = 0.5;         ///< and to have gone through what is further from its end than this
    int least_scans = 2;         ///< that saw a cell free
  };
  Space space = {};
};

}  // namespace crsm
