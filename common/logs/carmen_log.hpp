#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/logs/gzip_file.hpp"
#include "common/logs/laser_source.hpp"
#include "common/logs/log_clock.hpp"
#include "common/logs/unique_utimes.hpp"

namespace crsm {

/// Scans of a CARMEN log, plain or compressed by gzip: its FLASER and ROBOTLASER1 lines, in the log's order.
///
/// FLASER: beam 0 looks at -90 deg, counter-clockwise; the step is 1 deg for 180 or 181 beams, 0.5 deg for 360 or 361,
/// 0.25 deg for 720 or 721, and 180 deg / (n - 1) for any other number. ROBOTLASER1: start angle and step stand in the
/// line; a reading at or beyond its max_range, where that is positive, becomes 0 = no return.
/// Both take the utime from ipc_timestamp, and where that tells scans not apart (LogClock) from logger_timestamp or
/// from their number; and the odometry from the robot's pose, which is that scan's. The laser's pose is not used: in
/// logs that somebody corrected it is no odometry.
///
/// Counted: "bad_line" (a number that is none, too few or too many fields, beams outside 2..65536, a line longer than
/// 1 MiB, a last line cut short), "utime_repeated" (the utime of an earlier scan), "truncated" (the gzip stream is cut
/// short or damaged; what was whole is used). All of these but the last are skipped. Also counted: "bad_odometry" (a
/// pose that is none; the scan is used). Other kinds of lines are no concern of ours.
class CarmenLog : public LaserSource {
 public:
  /// Throws std::runtime_error if the file cannot be opened, or no temporary one be made.
  explicit CarmenLog(const std::string& path);

  std::optional<LaserScan> Next() override;
  std::optional<Pose2> Odometry() const override { return T_odom_robot_; }
  std::string OdometryName() const override { return "the robot's pose in its lines"; }
  double Progress() const override { return file_.Progress(); }
  std::map<std::string, std::int64_t> Counts() const override { return counts_; }
  std::vector<std::string> Complaints() const override;
  std::vector<std::string> OdometryNotes() const override;

 private:
  GzipFile file_;
  std::int64_t num_lines_ = 0;
  std::string first_bad_;  ///< which line was the first that is bad, and what is wrong with it
  std::string thinned_;    ///< as of ThinBeams
  std::map<std::string, std::int64_t> counts_;
  LogClock clock_;
  UniqueUtimes utimes_;                ///< given out so far
  std::optional<Pose2> T_odom_robot_;  ///< of the last scan given out
};

/// Whether one of the next `max_lines` lines of the file is a laser's.
bool HasCarmenLaser(GzipFile& file, int max_lines);

/// Microseconds from seconds in decimal notation ("976052905.167303", "1.13486e+09"), exactly: the text never becomes a
/// double, which holds hardly one such time exactly. What is beyond a microsecond is rounded, half up. Nothing if the
/// text is not digits with at most one point between them and perhaps an exponent, or beyond 9e12 s.
std::optional<std::int64_t> ParseUtime(std::string_view seconds);

}  // namespace crsm
