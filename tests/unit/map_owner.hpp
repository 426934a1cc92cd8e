#pragma once

#include <optional>
#include <vector>

#include "common/map/map_updater.hpp"
#include "services/map_updater/answers.hpp"
#include "synthetic_scans.hpp"

namespace crsm {

/// What map_updater is to its replicas: answers matches for everybody and requests page by page.
class MapOwner {
 public:
  /// Answers the next scan, taken a little further on. after: what that brings about.
  std::vector<map_delta_t> Answer(MatchState state = MatchState::kOk, const AfterMatch& after = {}) {
    const auto k = static_cast<double>(history.size());
    const ScanMatch match{100 + static_cast<std::int64_t>(history.size()),
                          {0.03 * k, 0.01 * k, 0.0},
                          0.9,
                          1,
                          1,
                          updater_.version(),
                          state};
    const MapDelta delta = updater_.Update(AllRays(ScanRoom(match.T_map_laser, match.utime, 180)), match);
    for (const TileChange& change : delta.tiles) map.Apply(change);
    history.push_back(match);
    answered_.Append(match);
    tracking.Add(match, after);
    return MakeParts(delta, match, updater_.geometry(), {epoch, kMostBytes}, after);
  }

  map_delta_t Page(const map_request_t& request) const {
    return MakePage(request, updater_, {answered_, tracking}, {epoch, kMostBytes});
  }
  map_delta_t AnswerAgain(std::int64_t utime) const { return MakeEmptyAnswer(utime, updater_, {epoch, kMostBytes}); }

  std::int64_t version() const { return updater_.version(); }
  std::size_t num_tiles() const { return updater_.num_tiles(); }

  static constexpr double kCellSize_m = 0.02;       ///< the room is about forty tiles, several messages large
  static constexpr std::size_t kMostBytes = 32000;  ///< of a message

  std::int64_t epoch = ++last_epoch;  ///< each owner begins a map of its own
  std::vector<ScanMatch> history;
  TrackingState tracking;
  ByteMap map{kCellSize_m};  ///< what all deltas together make

 private:
  static inline std::int64_t last_epoch = 0;

  static UpdateParameters FineParameters() {
    UpdateParameters parameters = TestParameters().update;
    parameters.cell_size_m = kCellSize_m;
    return parameters;
  }

  MapUpdater updater_{FineParameters()};
  MatchStore answered_;
};

}  // namespace crsm
