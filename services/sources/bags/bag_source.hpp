#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/logs/laser_source.hpp"
#include "common/logs/log_clock.hpp"
#include "common/parameters.hpp"
#include "services/diagnosis/laser_frames.hpp"
#include "services/sources/bags/bag_reader.hpp"
#include "services/sources/laser_choice.hpp"
#include "services/sources/scans_with_odometry.hpp"

namespace crsm {

class BagOdometry;

/// Scans of a bag (OpenBag), in the order in which they stand in it: the recorder's own, whatever their stamps say.
///
/// Odometry: from a topic of nav_msgs/Odometry or from TF (BagOdometry).
///
/// Counted and skipped: "bad_message" (a message that is no sweep), "other_frame" (of another laser on the topic),
/// "utime_repeated" (the time of an earlier scan), "bad_odometry" (one that is none), "bad_chunk" (damaged parts of the
/// bag). Also counted: "truncated" (the bag ends before its end; what was whole is used).
class BagSource : public LaserSource {
 public:
  /// laser: whose scans to take. Throws std::runtime_error that lists the topics, or the frames of the scans, where
  /// that does not tell which. odometry: its topic, or frame of TF; empty for the usual ones. Throws std::runtime_error
  /// too if the bag has not what it names.
  BagSource(const std::string& path, const LaserChoice& laser, const std::string& odometry = "",
            const ScanParameters& parameters = {});

  ~BagSource() override;

  std::optional<LaserScan> Next() override;
  std::optional<Pose2> Odometry() const override { return scans_.T_odom_robot(); }
  std::string OdometryName() const override;
  std::string Channel() const override { return laser_.name; }
  bool IsUpsideDown() const override;
  double Progress() const override { return bag_->Progress(); }
  std::map<std::string, std::int64_t> Counts() const override;
  std::vector<std::string> Complaints() const override;
  std::vector<std::string> OdometryNotes() const override;

 private:
  BagSource(const std::string& path, const std::set<BagTopic>& topics, const LaserChoice& laser,
            const std::string& odometry, const ScanParameters& parameters);
  void StudyFirstScans(const std::string& path, const std::string& wanted);
  void Take(const BagMessage& message);
  void TakeScan(std::string_view data);

  BagTopic laser_;
  ScanParameters laser_parameters_;  ///< as of FromRosScan
  LaserFrames frames_;
  std::unique_ptr<BagOdometry> odometry_;
  std::unique_ptr<BagReader> bag_;
  std::map<std::string, std::int64_t> counts_;
  std::string first_refusal_;
  std::string thinned_;        ///< as of ThinBeams
  std::string contradiction_;  ///< in the header of the first scan that has one
  LogClock clock_;
  ScansWithOdometry scans_;
};

}  // namespace crsm
