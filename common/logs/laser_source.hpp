#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/math/pose2.hpp"
#include "common/scan/laser_scan.hpp"

namespace crsm {

/// Where scans come from: a log, a simulated world, or a laser.
class LaserSource {
 public:
  virtual ~LaserSource() = default;

  /// The next scan, in the order of the source; nothing at its end. Bad entries are counted and skipped.
  /// Throws std::runtime_error if the source cannot be read on.
  virtual std::optional<LaserScan> Next() = 0;

  /// Whether scans come when a laser measures them, not when they are asked for. Then Next() waits, and its end is that
  /// of the process.
  virtual bool IsLive() const { return false; }

  /// Of a live source: the next scan if one comes within about `longest`.
  virtual std::optional<LaserScan> Poll(std::chrono::milliseconds /*longest*/) { return Next(); }

  /// Where in the source the scans come from, if it has several places for them: channel or topic. Else empty.
  virtual std::string Channel() const { return ""; }

  /// Where the laser truly stood at the last scan given, seen from where it stood at the first: of simulated worlds.
  virtual std::optional<Pose2> TruePose() const { return std::nullopt; }

  /// Where the robot stood at the last scan given, by its wheels (T_odom_robot), as RoundOdometry leaves it; nothing
  /// where the source has none. Where the source knows the laser's place on the robot, the laser's pose instead
  /// (T_odom_laser).
  virtual std::optional<Pose2> Odometry() const { return std::nullopt; }

  /// Which odometry that is: "base_link in /odom". Empty where there is none so far.
  virtual std::string OdometryName() const { return ""; }

  /// Whether the source says that the laser hangs upside down, as the TF of a bag may: its scans are mirror images.
  virtual bool IsUpsideDown() const { return false; }

  /// How much of the source has been read, [0, 1].
  virtual double Progress() const = 0;

  /// What was counted on the way, by name ("bad_line", "utime_repeated", ...). Names with a count of 0 may be missing.
  virtual std::map<std::string, std::int64_t> Counts() const = 0;

  /// What is wrong with the scans, a sentence each: those that were left out, where they were too many to be an
  /// accident (left_out.hpp), and what mends it; beams that were thinned.
  virtual std::vector<std::string> Complaints() const { return {}; }

  /// What a user is to know of the odometry so far: how many scans have it, or why it cannot be used. Sentences that
  /// begin behind the name of the source: "gives odometry to 3 of 3 scans (/odom)".
  virtual std::vector<std::string> OdometryNotes() const { return {}; }
};

}  // namespace crsm
