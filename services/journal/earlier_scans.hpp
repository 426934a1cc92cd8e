#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "common/logs/utime_index.hpp"
#include "common/scan/critical_rays.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// When two scans of one time are taken for the same.
struct SameScanConstants {
  std::size_t num_compared = 32;  ///< rays of a scan, at most
  double least_share = 0.9;       ///< of them that must agree: who wrote a log anew may have left out some beams
  float angle_rad = 1e-3f;        ///< by which an angle may differ, ...
  float range_m = 0.02f;          ///< ... and a range: other programs round to centimetres
};

/// The scans of a map that goes on. Tells which scans of a log are in it already, and which are of another drive whose
/// clock gave the same times, as a simulated clock that begins at 0 each time.
///
/// A drive ends where the clock begins anew. The scans that were drawn are in the journal: a log that has another scan
/// in the place of one of them is not that drive. Those that were not drawn are known by their times alone.
class EarlierScans {
 public:
  explicit EarlierScans(const SameScanConstants& constants = {}) : constants_(constants) {}

  /// The next scan of the map, in its order; nullptr where it was not drawn.
  void Add(const CriticalRays* scan, const ScanMatch& match);

  /// Another log begins.
  void BeginLog() { contradicted_.clear(); }

  /// Whether this scan of the log is in the map.
  bool Has(std::int64_t utime, const ValidRays& rays);

  /// Whether the log has other scans than a drive of the map at the same times.
  bool is_another_drive() const { return !contradicted_.empty(); }

  /// The largest utime in the map; scans of later ones are new.
  std::int64_t newest_utime() const { return newest_utime_; }

  /// Scans of all logs that were compared with a drawn one of the map, and are the same.
  std::int64_t num_same() const { return num_same_; }

 private:
  /// What is kept of a scan that was drawn.
  struct Drawn {
    ValidRays rays;  ///< some, deskewed
    Twist twist;     ///< by which they were
  };

  std::size_t DriveOf(std::int64_t scan) const;
  bool IsSame(const ValidRays& rays, const Drawn& drawn) const;

  SameScanConstants constants_;
  UtimeIndex utimes_;
  std::vector<std::int64_t> drives_;  ///< number of the first scan of each
  std::optional<std::int64_t> last_utime_;
  std::int64_t newest_utime_ = -1;
  std::map<std::int64_t, Drawn> drawn_;  ///< by utime
  std::set<std::size_t> contradicted_;   ///< drives that this log is not
  std::int64_t num_same_ = 0;
};

/// Those of a journal, as far as it can be read. Throws std::runtime_error if there is no such file.
EarlierScans ReadEarlierScans(const std::filesystem::path& journal);

}  // namespace crsm
