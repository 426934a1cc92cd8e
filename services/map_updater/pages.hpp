#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "common/graph/background_map_error.hpp"
#include "common/graph/mapper.hpp"
#include "common/map/map_updater.hpp"
#include "common/marks/mark.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "services/journal/match_store.hpp"
#include "services/replica/growing_message.hpp"

namespace crsm {

/// What an owner has besides its map.
struct Answered {
  const MatchStore& matches;      ///< all that were answered so far
  const TrackingState& tracking;  ///< after them
  /// Who knows better by now where the scans were taken; nullptr: they are to be told as they were matched.
  const Mapper* corrected = nullptr;
  /// With `corrected`: the component whose scans alone are told; nothing: all scans.
  std::optional<int> component = std::nullopt;
  /// Places with names, told to those who want matches, but of no component: asked for where they are told.
  std::function<std::vector<PlacedMark>()> place_marks = [] { return std::vector<PlacedMark>(); };
  /// With `corrected`: who estimates beside how far off its map may be; nullptr: it is told to those alone who want
  /// what is known in the end.
  BackgroundMapError* map_error = nullptr;
};

/// The next page of what a replica lacks: tiles that changed since its version, whole, and matches that it does not
/// have; everything, for a replica of another map. With the last tiles the tracking state, and with the last matches
/// the loops, how the map hangs together, and the places with names.
map_page_t MakePage(const map_request_t& request, const MapUpdater& updater, const Answered& answered,
                    const AnswerOptions& options);

}  // namespace crsm
