#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>

#include "common/math/pose2.hpp"

namespace crsm {

/// Where the robot stood by its odometry at a moment; or that the scan of that utime has no odometry.
struct Odometry {
  std::int64_t utime = 0;
  std::optional<Pose2> T_odom_robot = std::nullopt;
};

/// What is known of a scan's odometry.
struct ScanOdometry {
  enum class State {
    kAwaited,  ///< not yet known: no sample after the scan has come
    kNone,     ///< the scan has none
    kKnown,
  };
  State state = State::kAwaited;
  std::optional<Pose2> T_odom_robot = std::nullopt;  ///< where known
};

/// Which odometry is of a scan.
struct OdometryConstants {
  std::int64_t furthest_us = 100'000;  ///< no sample further from a scan than this says anything about it
};

/// The last samples of a robot's odometry, for scans that were taken at other moments than the samples.
///
/// Where utimes step back, scans and samples of before and after the step share their times: a scan is between two
/// samples only if they came one after the other with rising utimes, and of several such pairs between the last one.
/// The sample of a scan's own utime wins over all others; of two of the same utime the later one counts. Where a clock
/// begins anew, the samples before it are forgotten.
class OdometryBuffer {
 public:
  /// most: samples that are kept, >= 1; the oldest by arrival gives way.
  explicit OdometryBuffer(std::size_t most = 1024, const OdometryConstants& constants = {})
      : most_(most), constants_(constants) {}

  void Add(const Odometry& sample);

  /// What the sample of the scan's own utime says, kAwaited where there is none: for who must not depend on when other
  /// samples come.
  ScanOdometry FindExact(std::int64_t utime) const;

  /// The same; where there is no such sample, the pose between the two around the scan: position and heading
  /// proportional to time, the heading the shorter way round, rounded by RoundOdometry. kAwaited while the next sample
  /// may still be the one after the scan; kNone where one of the two is too far away, or where utimes
  /// stepped back between them.
  ScanOdometry Find(std::int64_t utime) const;

 private:
  std::size_t most_;
  OdometryConstants constants_;
  std::deque<Odometry> samples_;  ///< in the order of their arrival, each utime once
  std::int64_t latest_utime_ = std::numeric_limits<std::int64_t>::min();  ///< of all that ever came
};

}  // namespace crsm
