#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/diagnosis/diagnosis_constants.hpp"
#include "common/map/byte_map.hpp"
#include "common/math/point.hpp"
#include "common/scan/scan_match.hpp"
#include "common/scan/valid_rays.hpp"

namespace crsm {

class Mapper;

enum class ChangeKind : std::int8_t {
  kNew = 0,   ///< something stands where the map is free
  kGone = 1,  ///< nothing stands where the map has something
};

/// "new" or "gone".
const char* Name(ChangeKind kind);

/// A thing that has come or gone since a map was made.
struct MapChange {
  ChangeKind kind = ChangeKind::kNew;
  Point middle;                  ///< of the smallest rectangle around what was seen of it, map frame
  double length_m = 0.0;         ///< of that rectangle: the longer side, ...
  double width_m = 0.0;          ///< ... and the other one
  double yaw_rad = 0.0;          ///< of the longer side, [-pi / 2, pi / 2]
  std::int64_t first_utime = 0;  ///< of the first scan that saw the change
  std::int32_t num_places = 0;   ///< from which it was seen, >= 1

  double area_m2() const { return length_m * width_m; }
  friend bool operator==(const MapChange&, const MapChange&) = default;
};

/// Compares what a robot sees on a finished map with that map. A ray that ends where the map is free votes for a new
/// thing there, one that passes through what stands in the map votes for a thing that has gone. No ray votes that an
/// error of the pose, of the range or of the cells may explain. What was new and is looked through later is none:
/// people walk on. What had gone and is seen to stand later has not.
class ChangeFinder {
 public:
  /// The map has to outlive this, and to stay as it is.
  explicit ChangeFinder(const ByteMap& map, const DiagnosisConstants::Changes& constants = {});
  ~ChangeFinder();
  ChangeFinder(ChangeFinder&&) noexcept;

  /// A scan that the map was made from: what it contradicts is an error of the map, or was not there all the time, and
  /// no change. Before all others.
  void Learn(const ValidRays& rays, const Pose2& T_map_laser);

  /// rays: deskewed. Scans that were lost, or taken where the last one was, say nothing.
  void Add(const ValidRays& rays, const ScanMatch& match);

  /// What has changed by all scans so far, the largest first; no more than kMost.
  std::vector<MapChange> Find() const;

  static constexpr std::size_t kMost = 500;

 private:
  class Votes;
  std::unique_ptr<Votes> votes_;
};

/// One that has learned all keyframes of the map, by all that is known of their poses. With no loops there are none.
/// Both have to outlive it, and the map to stay as it is.
ChangeFinder MakeChangeFinder(const Mapper& mapper, const ByteMap& map);

/// The area of the largest change; 0 without any [m2].
double LargestArea(const std::vector<MapChange>& changes);

/// A line for each, for the terminal: "new: 0.6 x 0.4 m at 1.2, 3.4, seen from 5 places".
std::vector<std::string> FormatChanges(const std::vector<MapChange>& changes);

/// Comma-separated values, with a head.
std::string FormatChangesCsv(const std::vector<MapChange>& changes);

}  // namespace crsm
