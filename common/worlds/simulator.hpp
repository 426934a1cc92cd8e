#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/logs/laser_source.hpp"
#include "common/math/pose2.hpp"
#include "common/math/random.hpp"
#include "common/worlds/world.hpp"

namespace crsm {

/// Drives a laser through a world: it turns on the spot towards the next waypoint and goes straight to it, at the
/// world's speeds, and takes a scan every 1 / rate seconds, each in an instant, or in a sweep that ends then. The first
/// scan is at 1 s, the last one at the end of the path. Ranges have Gaussian noise, then drop-outs and steps if the
/// world says so; 0 is no return. Wheels have noise of their own: they change no range of a seed. The same world and
/// seed give the same bytes everywhere.
class Simulator : public LaserSource {
 public:
  Simulator(const World& world, std::uint64_t seed);

  std::optional<LaserScan> Next() override;
  double Progress() const override;
  std::map<std::string, std::int64_t> Counts() const override { return {}; }

  /// Where the laser truly stood at the last scan given, seen from where it started; the origin before the first.
  std::optional<Pose2> TruePose() const override { return T_start_laser_; }

  /// T_odom_robot by the wheels, from the start as its origin; nothing in a world without wheels.
  std::optional<Pose2> Odometry() const override;
  std::string OdometryName() const override { return world_.wheels ? "the wheels of the world" : ""; }

 private:
  /// A turn on the spot or a straight way.
  struct Leg {
    Pose2 T_world_from;
    Pose2 T_from_to;
    double start_s = 0.0;
    double duration_s = 0.0;
  };

  void AddLeg(const Pose2& T_world_from, double forward_m, double turn_rad);
  std::size_t LegAt(double time_s) const;
  Pose2 PoseAt(double time_s) const;
  Point PlaceOf(const Companion& companion, double time_s) const;
  std::vector<Point> PeopleAt(double time_s) const;
  Pose2 RobotAt(double time_s) const;
  void TurnWheels(double from_s, double to_s);
  LaserScan Scan(double time_s);

  World world_;
  Random random_;
  Random wheel_random_;
  std::vector<Leg> legs_;
  double end_s_ = 0.0;
  std::size_t leg_ = 0;  ///< the one of the last scan
  std::int64_t num_scans_ = 0;
  Pose2 T_start_laser_;
  Pose2 T_odom_robot_;
};

}  // namespace crsm
