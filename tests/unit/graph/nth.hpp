#pragma once

#include <optional>

#include "common/graph/keyframe_graph.hpp"

namespace crsm {

/// The keyframe of that number on the first trajectory: most tests drive no other.
inline KeyframeId Nth(int number) { return {0, number}; }

/// None for -1.
inline std::optional<KeyframeId> NthOrNone(int number) {
  return number < 0 ? std::nullopt : std::optional(Nth(number));
}

/// Where it is, of all of them.
inline std::size_t IndexOf(KeyframeId id) { return static_cast<std::size_t>(id.number); }

}  // namespace crsm
