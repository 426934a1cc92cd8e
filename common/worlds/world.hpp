#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/math/point.hpp"
#include "common/math/pose2.hpp"
#include "common/math/trigonometry.hpp"

namespace crsm {

/// When something is there: by default always.
struct Stay {
  double from_s = 0.0;  ///< after the first scan
  double until_s = std::numeric_limits<double>::infinity();

  bool Includes(double time_s) const { return time_s >= from_s && time_s < until_s; }
  bool IsEndless() const { return until_s == std::numeric_limits<double>::infinity(); }
  bool IsAlways() const { return from_s == 0.0 && IsEndless(); }
};

struct Wall {
  Point from;
  Point to;
  Stay stay = {};
};

/// A place that is found again in a map, for CMSE.
struct Corner {
  std::string name;
  Point at;
};

inline constexpr double kPersonRadius_m = 0.2;

/// Somebody who walks to and fro, as a disc; from `from` on when the first scan is taken.
struct Person {
  Point from;
  Point to;
  double speed_m_s = 0.0;
  Stay stay = {};
};

/// Somebody who walks with the robot, as a disc: along its path, so far ahead of it, and so far to the left as it
/// looks. Before the start and beyond the end the path goes straight on.
struct Companion {
  double ahead_m = 0.0;  ///< along the path; negative behind
  double left_m = 0.0;   ///< negative to the right
  Stay stay = {};
};

/// A flat world of straight walls, the laser in it and the path that it is driven along.
struct World {
  struct Laser {
    double fov_rad = 0.0;  ///< beam i looks at -fov / 2 + i * fov / beams, counter-clockwise from straight ahead
    int beams = 0;         ///< 2 to 4096
    double range_max_m = 0.0;
    double rate_hz = 0.0;
    double noise_m = 0.0;      ///< standard deviation of a range
    double dropout = 0.0;      ///< share of the beams that have no return, though there is something
    double quantum_m = 0.0;    ///< ranges are whole multiples of it; 0 for exact ones
    double sweep_s = 0.0;      ///< from the first beam to the last, which is measured at the scan's time
    double angle_scale = 1.0;  ///< beams look at this share of the angle that the scan says, as a real SICK's do
  };

  /// What the wheels tell of a true way and a true turn of the robot: told = true * scale + noise.
  struct Wheels {
    double way_scale = 1.0;   ///< told way per true way
    double turn_scale = 1.0;  ///< told turn per true turn
    double way_noise = 0.0;   ///< standard deviation of a way of a metre [m]; it grows with the root of the way
    double turn_noise = 0.0;  ///< standard deviation of a turn of a radian [rad]; it grows with the root of the turn
    Pose2 T_robot_laser;      ///< the path of the world is the laser's
    double delay_s = 0.0;     ///< what is told at a time is the robot's pose so long before
  };

  std::vector<Wall> walls;
  std::vector<Point> path;  ///< two points or more, each different from the one before; no leg touches a lasting wall
  std::vector<Corner> corners;
  std::vector<Person> people;
  std::vector<Companion> companions;
  Laser laser;
  std::optional<Wheels> wheels;  ///< nothing: no odometry
  double linear_m_s = 0.0;
  double angular_rad_s = 0.0;
};

/// A world from its text. A line each, in any order but that of the waypoints, `#` begins a comment:
///
///     wall x1_m y1_m x2_m y2_m
///     box x_m y_m width_m height_m                       from its lower left corner; four walls
///     waypoint x_m y_m                                   two or more: the laser drives from one to the next
///     laser fov_deg beams range_max_m rate_hz noise_m    once; may end in `dropout SHARE`, `quantum_m STEP`,
///                                                        `sweep_s TIME` and `angle_scale SHARE`
///     speed linear_m_s angular_rad_s                     once
///     wheels way_scale turn_scale way_noise turn_noise   at most once, as World::Wheels: the robot has odometry; may
///                                                        end in `x_m X`, `y_m Y` and `yaw_deg A`, the place of the
///                                                        laser on the robot, and in `delay_s TIME`
///     corner NAME x_m y_m                                where walls meet, seen from both sides: what CMSE looks for
///     person x1_m y1_m x2_m y2_m speed_m_s               somebody who walks to and fro
///     companion ahead_m left_m                           somebody who walks with the robot, as Companion
///
/// Walls, boxes, people and companions that are not there all the time end in `from_s TIME`, `until_s TIME` or both.
///
/// Throws std::runtime_error that names `name`, the line and what would be right.
World ParseWorld(const std::string& text, const std::string& name);

/// The built-in worlds, each of common/worlds/NAME.world, in the order of their names.
std::vector<std::string> ListBuiltInWorlds();

/// What may stand after sim: but for files, for help and errors: "block, ..., twins, campus[:LENGTH_M[:NUMBER]]".
std::string DescribeBuiltInWorlds();

/// A built-in world ("demo": a flat of six rooms around a loop of corridors; "corridor": a twisted corridor; "env1" to
/// "env4": those of the paper's experiments; "twins", "rooms" and "symmetric": alike to themselves; "block": a long
/// round about a block; "hall": fast turns, rare scans), a campus (DrawCampus: "campus", "campus:10000" for a drive of
/// 10,000 m instead of 3,000 m, "campus:10000:2" for another one), or else the world in the file of that name. Throws
/// std::runtime_error if there is none, and as ParseWorld.
World LoadWorld(const std::string& name);

/// The text of the same.
std::string LoadWorldText(const std::string& name);

/// How far it is from `origin` along `direction` to the nearest wall [m]; infinity if there is none.
double CastRay(const std::vector<Wall>& walls, const Point& origin, const SinCos& direction);

/// The same for a disc; infinity from within it.
double CastRayAtDisc(const Point& centre, double radius_m, const Point& origin, const SinCos& direction);

}  // namespace crsm
