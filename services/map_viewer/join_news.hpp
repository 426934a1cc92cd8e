#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/graph/pieces.hpp"

namespace crsm {

/// What has become of a trajectory.
struct JoinEvent {
  enum class Kind { kAnotherPiece, kJoined, kJoinedFloating, kRejected, kFloats };
  Kind kind;
  std::int64_t trajectory;
  std::int64_t other = 0;  ///< an older one, that it was joined with

  friend bool operator==(const JoinEvent&, const JoinEvent&) = default;
};

/// Tells which trajectories of a map float, which are joined, and that another piece is the larger one, as it happens.
class JoinNews {
 public:
  /// What is new since the last call. The first time nothing is: it was so before; nor is where an older break is not
  /// told any more.
  std::vector<JoinEvent> Look(const MapPieces& pieces);

 private:
  std::int64_t first_ = 0;    ///< trajectory that is known, ...
  std::vector<int> numbers_;  ///< ... and for each from there on the number of its piece
};

/// A line, as "floating: not joined to the map yet (trajectory 3)". name: what a trajectory is called.
std::string Describe(
    const JoinEvent& event, const std::function<std::string(std::int64_t trajectory)>& name =
                                [](std::int64_t trajectory) { return "trajectory " + std::to_string(trajectory); });
std::vector<std::string> Describe(const std::vector<JoinEvent>& events);

/// Whether the map that is shown is another piece than the one that the run began with, as far as that is known.
bool IsFirstElsewhere(const MapPieces& pieces);

}  // namespace crsm
