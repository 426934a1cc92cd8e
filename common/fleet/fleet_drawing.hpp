#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/fleet/fleet.hpp"
#include "common/graph/pieces.hpp"
#include "common/graph/placed_loop.hpp"
#include "common/map/byte_map.hpp"
#include "common/map/map_updater.hpp"

namespace crsm {

/// When robots were where, by one clock: their own clocks need not agree.
class FleetClock {
 public:
  /// A keyframe of a map. heard_utime: when it was heard, by the one clock [us]: what is heard at once tells how the
  /// robot's clock goes, what is heard late tells nothing.
  void Add(const FleetKeyframeId& keyframe, std::int64_t utime, std::int64_t heard_utime);

  /// When a keyframe was taken [us].
  std::int64_t TimeOf(int map, std::int64_t utime) const;

  /// Where the robot of a map was at that time, in the frame of a piece; nothing if that is not known, or if it was not
  /// on that piece.
  std::optional<Pose2> FindPose(const FleetGraph& fleet, int map, std::int64_t time, int piece,
                                const FleetConstants& constants = {}) const;

 private:
  struct Map {
    std::map<std::int64_t, KeyframeId> keyframes;  ///< by utime
    std::optional<std::int64_t> offset;            ///< of the one clock against the robot's [us]
  };
  std::vector<Map> maps_;
};

/// What all robots saw, where it belongs on one piece of the common map, without the robots themselves: hits around
/// where another robot stood by its own pose are left out.
///
/// It is drawn when somebody wants to see it, some keyframes at a time.
class FleetDrawing {
 public:
  explicit FleetDrawing(const DrawingRules& rules, const FleetConstants& constants = {})
      : rules_(rules), constants_(constants), map_(rules) {}

  /// Keyframes are elsewhere than they were, or another piece is to be drawn.
  void Forget() { num_looked_at_ = 0; }

  /// Draws `most` keyframes of a piece that are not in the map yet, for the version of that number, no smaller than
  /// before. Whether all are drawn.
  bool Draw(const Fleet& fleet, const FleetClock& clock, int piece, std::int64_t version, int most);

  const MapUpdater& map() const { return map_; }

  /// The share of a keyframe's rays that end at walls of the map and pass through none, [0, 1].
  double ComputeAgreement(const Fleet& fleet, const FleetKeyframeId& keyframe);

  /// The rays of a keyframe that end at no other robot.
  ValidRays WithoutRobots(const Fleet& fleet, const FleetClock& clock, const FleetKeyframeId& keyframe) const;

 private:
  DrawingRules rules_;
  FleetConstants constants_;
  MapUpdater map_;
  std::size_t num_looked_at_ = 0;  ///< of the fleet's keyframes
  std::optional<ByteMap> bytes_;   ///< the same map, as of bytes_version_
  std::int64_t bytes_version_ = -1;
};

/// The pieces of a fleet, each by its oldest trajectory: the one with the most keyframes first, which is the map that
/// is shown, then by size, of several the oldest first.
std::vector<int> SortPieces(const FleetGraph& fleet);

/// How the common map hangs together. Each trajectory but the first begins behind a break. pieces: as of SortPieces.
MapPieces DescribePieces(const Fleet& fleet, const std::vector<int>& pieces);

/// The newest loops on the piece that is shown, those that hold first.
std::vector<PlacedLoop> PlaceLoops(const FleetGraph& fleet, int piece);

}  // namespace crsm
