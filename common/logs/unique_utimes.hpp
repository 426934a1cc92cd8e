#pragma once

#include <cstdint>
#include <optional>

#include "common/logs/utime_index.hpp"

namespace crsm {

/// Gives each scan a utime of its own, because the utime is the identity of a scan. Several drives may have the same
/// times: a scan of a later drive gets the next free microsecond. A drive begins where the clock begins anew, and where
/// BeginDrive says so.
class UniqueUtimes {
 public:
  /// The next scan is of another drive.
  void BeginDrive();

  /// A utime that a scan of an earlier drive has already.
  void AddTaken(std::int64_t utime) { utimes_.Add(utime); }

  /// utime: of the next scan, by its clock [us]. Returns its own utime; nothing if the drive has this utime already, or
  /// if a thousand microseconds from there on are taken.
  std::optional<std::int64_t> Add(std::int64_t utime);

  /// How many scans have got a utime.
  std::int64_t size() const { return utimes_.size(); }

 private:
  UtimeIndex utimes_;
  std::int64_t first_of_drive_ = 0;            ///< in the order of arrival
  std::optional<std::int64_t> last_of_clock_;  ///< utime of the last scan of this drive, by its clock
};

}  // namespace crsm
