#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/graph/keyframe_graph.hpp"
#include "common/math/point.hpp"

namespace crsm {

enum class MarkAction {
  kSeen,    ///< sightings of one id are one place
  kMoved,   ///< the place is this alone, also one that was removed
  kRemoved  ///< what is seen of it later says nothing
};

/// What somebody says of a place with a name. By its id and utime it is known when it comes again.
struct Mark {
  std::int64_t utime = 0;  ///< when it was seen, by the clock of the scans, or said [us]
  std::string id;
  std::string kind;
  std::string name = {};
  MarkAction action = MarkAction::kSeen;
  bool in_map_frame = false;       ///< else the points are in the frame of the laser at `utime`
  double radius_m = 0.5;           ///< standard deviation of each coordinate
  std::vector<Point> points = {};  ///< one, or three and more for an outline, closed; none of one that is removed

  static constexpr std::size_t kLongestText = 63;  ///< bytes of an id or a name
  static constexpr std::size_t kLongestKind = 31;
  static constexpr std::size_t kMostPoints = 64;
  static constexpr double kLeastRadius_m = 0.001;
  static constexpr double kLargestRadius_m = 1000.0;
  static constexpr double kFarthest_m = 1e6;  ///< of a coordinate
};

/// Kinds of zones that become masks of a navigation: an outline that robots must not enter, or only slowly.
inline constexpr const char* kKeepOutKind = "keep-out";
inline constexpr const char* kSlowKind = "slow";

/// In one line, what is wrong with a mark and what would be right; empty if nothing is.
std::string DescribeFault(const Mark& mark);

/// Whether a point is on any map: it is finite, and within Mark::kFarthest_m.
bool IsOnMaps(const Point& point);

/// A point that moves with a keyframe.
struct FixedPoint {
  std::optional<KeyframeId> keyframe;  ///< none: the point is in the map's frame
  Point at;                            ///< in the frame of the laser at the keyframe
};

/// A mark as it is kept: its points where they are fixed.
struct FixedMark {
  Mark mark;
  std::vector<FixedPoint> points;
};

/// A place where it lies by all that is known.
struct PlacedMark {
  std::int64_t utime = 0;  ///< of the newest sighting
  std::string id;
  std::string kind;
  std::string name;
  int num_sightings = 0;
  /// Of a point: xx, xy, yy [m^2], as the sightings have it; how far the map itself is off comes on top.
  std::array<double, 3> covariance{};
  bool floating = false;      ///< on another piece than the map that is shown, in a frame of its own
  std::vector<Point> points;  ///< map frame

  /// Of all robots of a fleet. One robot has fewer: MarkBook::kMostMarks.
  static constexpr std::size_t kMostOnMap = 1000;
  static constexpr std::size_t kLongestText = 127;  ///< bytes of an id or a name: a fleet's begin with the robot's

  bool is_outline() const { return points.size() > 1; }
  friend bool operator==(const PlacedMark&, const PlacedMark&) = default;
};

/// The same of a place: its texts may be as long as those of a fleet.
std::string DescribeFault(const PlacedMark& mark);

/// A place as the keyframes of its map have it: wherever they are moved, it moves along.
struct AnchoredMark {
  PlacedMark mark;  ///< without points; the covariance is in the frame of the laser at the first keyframe
  struct Anchor {
    KeyframeId keyframe;
    Point at;  ///< in the frame of the laser there
    friend bool operator==(const Anchor&, const Anchor&) = default;
  };
  std::vector<Anchor> points;
  friend bool operator==(const AnchoredMark&, const AnchoredMark&) = default;
};

/// The covariance of a point, xx, xy, yy [m^2], in a frame that is turned against its own.
std::array<double, 3> TurnCovariance(const std::array<double, 3>& covariance, double yaw_rad);

/// The middle of a place, where its name stands.
Point MiddleOf(const PlacedMark& mark);

}  // namespace crsm
