#pragma once

#include <optional>
#include <vector>

#include "common/graph/mapper.hpp"
#include "common/map/map_updater.hpp"
#include "common/match/tracking_state.hpp"
#include "services/journal/match_store.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// What all answers of an owner have in common.
struct AnswerOptions {
  std::int64_t epoch = 0;          ///< of its map
  std::size_t most_bytes = 32000;  ///< of a message; a tile stays whole: one alone makes 4.4 KB at most
};

/// What a match changed in the map, for everybody: one message, or more where it would be too large.
std::vector<map_delta_t> MakeParts(const MapDelta& delta, const ScanMatch& match, const MapGeometry& geometry,
                                   const AnswerOptions& options, const AfterMatch& after = {});

/// The answer to a match that comes once more after others were answered: the version that there is, and nothing else.
map_delta_t MakeEmptyAnswer(std::int64_t utime, const MapUpdater& updater, const AnswerOptions& options);

/// What an owner has besides its map.
struct Answered {
  const MatchStore& matches;      ///< all that were answered so far
  const TrackingState& tracking;  ///< after them
  /// Who knows better by now where the scans were taken; nullptr: they are to be told as they were matched.
  const Mapper* put_right = nullptr;
  /// With `put_right`: the component whose scans alone are told; nothing: all scans.
  std::optional<int> component = std::nullopt;
};

/// The next page of what a replica lacks: tiles that changed since its version, whole, and matches that it does not
/// have, or the tracking state in the last page; everything, for a replica of another map. With it the answer to what
/// it asks about a scan, and with the last matches the loops, and how the map hangs together.
map_delta_t MakePage(const map_request_t& request, const MapUpdater& updater, const Answered& answered,
                     const AnswerOptions& options);

}  // namespace crsm
