#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/scan/laser_scan.hpp"
#include "common/scan/utime_unit.hpp"

namespace crsm {

/// When a log's stamps are not believed.
struct LogClockConstants {
  int num_studied = 50;            ///< first scans, which are read ahead
  int enough_standing = 10;        ///< steps that stand still, and ...
  double standing_share = 0.6;     ///< ... more than that share of all: half are two lasers that measure together
  double recorded_standing = 0.1;  ///< the clock of a recorder stands still in no more of them
  double pace_difference = 0.2;    ///< to the recorder's, of stamps in the right unit
  /// Between scans that are numbered. Thinned logs have about one a second; a shorter time would make their robot too
  /// fast to be followed, and dense logs are mapped alike.
  std::int64_t period_us = 1'000'000;
};

/// The time of each scan of a log, where the stamps do not tell it: zeros, times rounded to six digits ("1.13486e+09")
/// or to seconds, another unit than microseconds. The first scans decide, for all.
///
/// Stamps that are right stay as they are, also where they step back, and where a scan repeats the stamp of another.
class LogClock {
 public:
  explicit LogClock(const LogClockConstants& constants = {}) : constants_(constants) {}

  /// One of the first scans, before the log is read; its utime is its stamp. recorded_utime: when it was recorded [us],
  /// where the log has that.
  void Study(const LaserScan& scan, std::optional<std::int64_t> recorded_utime = std::nullopt);
  bool HasStudiedEnough() const { return num_studied_ >= constants_.num_studied; }

  /// The utime of the next scan. Nothing where the stamps do not tell it and this is the last scan once more, or was
  /// recorded before all time.
  std::optional<std::int64_t> TimeOf(const LaserScan& scan, std::optional<std::int64_t> recorded_utime = std::nullopt);

  /// Another stamp of the log, of odometry say, in microseconds.
  std::int64_t ToMicroseconds(std::int64_t stamp) const;

  /// What was made of the stamps; empty where they are right. stamp: what the log calls them, "ipc_timestamp".
  std::string Complaint(const std::string& stamp) const;

 private:
  enum class Time { kStamp, kStampInOtherUnit, kRecorded, kNumber };

  /// What a clock showed at the first scans.
  struct Readings {
    std::optional<std::int64_t> first = std::nullopt;
    std::int64_t last = 0;
    int num_steps = 0;
    int num_standing = 0;  ///< of the steps

    void Add(std::int64_t utime);
    double MeanStep() const;
  };

  bool StampsStand() const;
  bool RecorderIsBelieved() const;
  bool IsPaceOfRecorder(const UtimeUnit& unit) const;
  std::optional<UtimeUnit> OtherUnit() const;
  Time WhichTime() const;

  LogClockConstants constants_;
  int num_studied_ = 0;  ///< scans; one that was sent again counts once
  std::optional<LaserScan> last_studied_;
  Readings stamps_;
  Readings recorded_;
  std::optional<LaserScan> last_;  ///< that was given a time of another kind than its stamp
  std::int64_t num_numbered_ = 0;
};

}  // namespace crsm
