#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/graph/graph_constants.hpp"
#include "common/match/match_constants.hpp"
#include "common/math/point.hpp"
#include "common/math/pose2.hpp"
#include "common/scan/scan_match.hpp"

namespace crsm {

/// Why a trajectory ended and another one began.
enum class BreakReason : std::int8_t {
  kLost = 0,     ///< scans were lost for too long
  kGap = 1,      ///< no scan came for too long
  kClock = 2,    ///< the clock of the scans went back
  kSession = 3,  ///< none of these: a session or another log began
};

/// "lost", "gap", "clock" or "session".
const char* Name(BreakReason reason);

/// Where a trajectory began, and how the robot came there is not known.
struct Break {
  std::int64_t utime = 0;  ///< of the first scan behind it
  std::int64_t scan = 0;   ///< number of that scan, counted from 0
  BreakReason reason = BreakReason::kLost;
  /// Since the last scan that was matched (lost), or since the last scan (gap, session); by how much the clock went
  /// back (clock). Never negative.
  double seconds = 0.0;
  Pose2 T_map_before;    ///< of the last scan before it that was matched, corrected, in the frame of piece_before
  int piece_before = 1;  ///< on which the trajectory before ended; 1 is the largest piece
  int piece = 1;         ///< on which the new trajectory is
  /// Whether both sides hang together by loops.
  bool joined() const { return piece == piece_before; }
  friend bool operator==(const Break&, const Break&) = default;
};

/// How far off a map may be there: more in one of twenty.
struct Doubt {
  Point at;  ///< map frame
  double off_m = 0.0;
  friend bool operator==(const Doubt&, const Doubt&) = default;
};

/// A drive that would tell most of what is not known of a map: from one place to another, by another way than the one
/// that is mapped.
struct WayBack {
  Point from;  ///< map frame
  Point to;
  double then_m = 0.0;  ///< so far off the map may be after it
  friend bool operator==(const WayBack&, const WayBack&) = default;
};

/// How far off a map may be, when it is laid on the building as well as it can be: more in one map of twenty.
struct MapError {
  static constexpr std::size_t kMostDoubts = 1000;

  double most_m = 0.0;                             ///< the place that is furthest off
  Point at;                                        ///< near where that is likely, map frame
  std::vector<Doubt> doubts = {};                  ///< along the path, kMostDoubts
  std::optional<WayBack> way_back = std::nullopt;  ///< nothing where none would help much
  friend bool operator==(const MapError&, const MapError&) = default;
};

/// A step of the path that its match told wrongly, as loops say.
struct Slip {
  Point at;            ///< map frame
  double off_m = 0.0;  ///< by so much the loops corrected it
  friend bool operator==(const Slip&, const Slip&) = default;
};

/// A part of the map that hangs together by loops, with a frame of its own.
struct MapPiece {
  std::int64_t keyframes = 0;
  std::int64_t scans = 0;  ///< that were matched
  double way_m = 0.0;      ///< that the robot drove there, from keyframe to keyframe
  friend bool operator==(const MapPiece&, const MapPiece&) = default;
};

/// How a map hangs together.
struct MapPieces {
  static constexpr std::size_t kMostPieces = 50;
  static constexpr std::size_t kMostBreaks = 200;

  std::int64_t num_pieces = 0;
  std::int64_t num_breaks = 0;
  std::int64_t num_matched = 0;  ///< scans that were matched, in all pieces
  std::int64_t num_bridged = 0;  ///< breaks over which pieces hang together by the wheels alone
  std::int64_t num_keyframes = 0;
  std::int64_t num_closed = 0;        ///< loops that hold
  std::int64_t num_rejected = 0;      ///< loops that the others contradicted later
  std::vector<MapPiece> pieces = {};  ///< the first is the map that is shown, the others follow by size; kMostPieces
  std::vector<Break> breaks = {};     ///< the newest ones, oldest first; kMostBreaks
  /// Of the map that is shown; nothing where it is not known, or was not asked for.
  std::optional<MapError> error = std::nullopt;
  std::optional<Slip> slip = std::nullopt;  ///< the largest one of the map that is shown, if it is one

  /// Numbers of the pieces that get a map of their own beside that of piece 1.
  std::vector<int> OthersWithMap(const GraphConstants::Pieces& constants = {}) const;
  friend bool operator==(const MapPieces&, const MapPieces&) = default;
};

/// What is to be known of each trajectory, gathered match by match.
class TrajectoryLog {
 public:
  explicit TrajectoryLog(const MatchConstants::Break& constants = {}) : constants_(constants) {}

  struct Trajectory {
    Break start;  ///< but for the pose and the pieces
    std::int64_t num_matched = 0;
    std::int64_t last_matched = 0;  ///< scan, ...
    Pose2 T_map_last;               ///< ... and where it was matched
  };

  /// The next scan. num_trajectories: how many there are with it.
  void Add(const ScanMatch& match, int num_trajectories);

  std::int64_t num_scans() const { return num_scans_; }
  int size() const { return static_cast<int>(trajectories_.size()); }
  const Trajectory& at(int trajectory) const { return trajectories_[static_cast<std::size_t>(trajectory)]; }
  /// The scan behind the last one of a trajectory.
  std::int64_t EndOf(int trajectory) const {
    return trajectory + 1 < size() ? at(trajectory + 1).start.scan : num_scans_;
  }

 private:
  Break MakeBreak(const ScanMatch& match) const;

  MatchConstants::Break constants_;
  std::vector<Trajectory> trajectories_;
  std::int64_t num_scans_ = 0;
  std::int64_t num_lost_ = 0;          ///< of the newest scans, in a row
  std::int64_t last_utime_ = 0;        ///< of the newest scan
  std::int64_t last_match_utime_ = 0;  ///< of the newest that was matched
};

}  // namespace crsm
