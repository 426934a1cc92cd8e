#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/logs/unique_utimes.hpp"
#include "common/scan/laser_scan.hpp"
#include "common/scan/odometry_buffer.hpp"

namespace crsm {

/// The scans of a log in its order, each with the odometry of its own utime or what lies between the two around it
/// (OdometryBuffer). For it a scan is held back until the odometry has come past it, another scan is later by more than
/// a second, or eight more scans wait: recorders get odometry and TF up to 0.2 s after the scan.
class ScansWithOdometry {
 public:
  /// False, and nothing done, if an earlier scan of the same drive has its utime; UniqueUtimes says what a drive is.
  bool Add(LaserScan scan);
  void Add(const Odometry& odometry) { odometry_.Add(odometry); }

  /// Whether the odometry of the scan that has waited longest is known, or is waited for no longer.
  bool NextIsReady() const;

  /// The scan that has waited longest, ready or not; nothing if none waits.
  std::optional<LaserScan> Next();

  /// Of the last scan given out.
  const std::optional<Pose2>& T_odom_robot() const { return T_odom_robot_; }

  std::int64_t num_scans() const { return utimes_.size(); }              ///< that were added
  std::int64_t num_with_odometry() const { return num_with_odometry_; }  ///< of those given out

  /// Why the odometry was of no use to any scan, in words for people.
  std::string ExplainNoOdometry() const;

  /// What is wrong with scans that were left out, "bad_message" and "utime_repeated" of `counts`, where these are worth
  /// a word (left_out.hpp). channel: theirs. refusal: why the first one was bad; empty where nobody knows. time: what a
  /// driver has to set.
  std::vector<std::string> Complaints(const std::string& channel, const std::map<std::string, std::int64_t>& counts,
                                      const std::string& refusal, const std::string& time) const;

 private:
  struct Waiting {
    LaserScan scan;
    std::int64_t clock_utime;  ///< as the log says it; odometry is found by it
  };

  OdometryBuffer odometry_;
  UniqueUtimes utimes_;          ///< of all scans so far
  std::deque<Waiting> waiting_;  ///< for their odometry, in the log's order
  std::optional<Pose2> T_odom_robot_;
  std::int64_t num_with_odometry_ = 0;
  std::int64_t num_given_up_ = 0;  ///< scans for which odometry was waited in vain
};

}  // namespace crsm
