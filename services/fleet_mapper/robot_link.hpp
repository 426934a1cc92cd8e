#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/fleet/fleet.hpp"
#include "services/base/backoff.hpp"
#include "services/wire/graph_messages.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// What one robot tells of its map: KEYFRAME and POSE_GRAPH come in, any of them may be lost, late or doubled;
/// keyframes go out one by one in their order, each when it is known what the robot's own loop closer has found there.
/// What is lacking is asked for (KEYFRAME_REQUEST), and every few seconds whether there are other places.
///
/// A robot that was restarted goes on with its map, if that begins as the one before; else it has begun a new one.
///
/// It touches neither network nor clock.
class RobotLink {
 public:
  using Clock = Backoff::Clock;
  static constexpr std::size_t kMostWaiting = 256;  ///< keyframes that wait for others; more are asked for later
  static constexpr std::size_t kMostMaps = 64;      ///< of a robot: what begins more often is no robot

  /// prefix: of the robot's channels. fleet: has the keyframes that were given out.
  RobotLink(std::string prefix, const Fleet& fleet) : prefix_(std::move(prefix)), fleet_(fleet) {}

  const std::string& prefix() const { return prefix_; }

  void Take(const keyframe_t& message, Clock::time_point now, std::int64_t utime_now);
  void Take(const pose_graph_t& message);
  /// The places of the robot's map, where they are others than before, and those keyframes are there.
  std::optional<fleet_marks_t> Take(const robot_marks_t& message, Clock::time_point now);
  /// Those of a map are held, of an earlier session.
  void Hold(const fleet_marks_t& marks) { marks_held_[marks.map] = marks.marks.checksum; }

  /// A keyframe that is the next of its map.
  struct Told {
    std::optional<int> map;  ///< of the fleet; none: it begins a new one, for which Begin is to be called
    keyframe_t message;
    std::int64_t heard_utime;  ///< when it was heard first
  };
  /// The next keyframe, if it is complete; it counts as given out.
  std::optional<Told> Next(Clock::time_point now);
  /// The robot has begun this map, with the keyframe that was given out last; or has, in an earlier session.
  void Begin(int map, std::int64_t epoch);

  /// What is lacking, if it is time to ask.
  std::optional<keyframe_request_t> NextRequest(Clock::time_point now);

  std::int64_t epoch() const { return epoch_; }           ///< 0: the robot was not heard yet
  std::optional<int> map() const { return map_; }         ///< none: it has not begun one yet
  const std::vector<int>& maps() const { return maps_; }  ///< of this robot, the newest last
  /// Keyframes that the robot has, and that were not given out.
  bool is_behind() const { return known_ > given_; }
  /// Whether its places were told a moment ago; else they are asked for at once. A robot without a map has none.
  bool HasToldMarks(Clock::time_point now);
  /// Keyframes wait for nothing but the robot's loop closer.
  bool waits_for_loop_closer() const;

 private:
  struct Waiting {
    keyframe_t message;
    std::int64_t heard_utime;
  };

  bool IsOfCurrentMap(const keyframe_t& message);
  void BeginEpoch(std::int64_t epoch);
  void Identify(const keyframe_t& first);
  bool ContradictsGiven(const keyframe_t& message) const;

  std::string prefix_;
  const Fleet& fleet_;
  std::int64_t epoch_ = 0;
  std::vector<std::int64_t> epochs_before_;
  std::vector<int> maps_;
  std::optional<int> map_;
  bool is_identified_ = false;       ///< whether it is known that this epoch goes on with a map, or begins one
  std::optional<KeyframeId> given_;  ///< the newest keyframe of this map that was given out
  std::optional<KeyframeId> known_;  ///< the newest keyframe that the robot has
  std::map<KeyframeId, Waiting> waiting_;
  Backoff backoff_{std::chrono::milliseconds(200), std::chrono::seconds(5)};
  /// A robot that stands sends nothing: it is asked now and then whether it has gone on while it was not heard.
  static constexpr auto kSilence = std::chrono::seconds(30);
  Clock::time_point next_probe_{};
  static constexpr auto kMarksPeriod = std::chrono::seconds(5);
  std::map<int, std::int64_t> marks_held_;  ///< checksums by map of the fleet
  std::optional<Clock::time_point> marks_told_;
  Clock::time_point next_marks_{};
};

}  // namespace crsm
