#pragma once

#include <cstddef>

#include "common/math/pose2.hpp"

namespace crsm {

/// A loop where its keyframes belong on the map, for those who show it.
struct PlacedLoop {
  Pose2 T_map_older;
  Pose2 T_map_newer;
  bool rejected = false;  ///< others contradicted it: it counts for nothing
  bool joins = false;     ///< it was the first to lead from one part of the map to another
  friend bool operator==(const PlacedLoop&, const PlacedLoop&) = default;
};

/// As many are shown, the newest ones, half of them closed and half of them rejected at most.
inline constexpr std::size_t kMostPlacedLoops = 200;

}  // namespace crsm
