#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "common/map/byte_map.hpp"
#include "common/map/map_updater.hpp"
#include "common/match/guess/tracking_state.hpp"
#include "services/bus/bus.hpp"
#include "services/wire/conversions.hpp"
#include "unit/synthetic_scans.hpp"

namespace crsm {

/// What map_updater is to its replicas, in little: answers each match with a delta, of one tile a part, and each
/// request with a page of a few tiles and matches. What its map is, a test says scan by scan or tile by tile.
class MapOwner {
 public:
  explicit MapOwner(const UpdateParameters& parameters = FineParameters())
      : map(parameters.cell_size_m), updater_(parameters) {}

  /// Answers a match that has changed these tiles. after: what it has brought about.
  std::vector<map_delta_t> Answer(const ScanMatch& match, std::span<const TileChange> changes,
                                  const AfterMatch& after = {}) {
    history.push_back(match);
    tracking.Add(match, after);
    map_delta_t part{};
    part.utime = match.utime;
    part.epoch = epoch;
    part.version = version();
    part.cell_size_m = map.geometry().cell_size_m();
    part.num_parts = static_cast<std::int32_t>(std::max<std::size_t>(1, changes.size()));
    std::vector<map_delta_t> parts(static_cast<std::size_t>(part.num_parts), part);
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i].part = static_cast<std::int32_t>(i);
    for (std::size_t i = 0; i < changes.size(); ++i) {
      Change(changes[i]);
      parts[i].num_tiles = 1;
      parts[i].tiles = {ToMessage(changes[i])};
    }
    if (after.T_new_old) {
      parts[0].num_corrections = 1;
      parts[0].T_new_old = {ToMessage(*after.T_new_old)};
    }
    parts[0].trajectory = after.trajectory;
    parts[0].floating = after.floating ? 1 : 0;
    return parts;
  }

  /// The same of a scan that is drawn.
  std::vector<map_delta_t> Draw(const CriticalRays& scan, const ScanMatch& match, const AfterMatch& after = {}) {
    return Answer(match, updater_.Update(scan, match).tiles, after);
  }

  /// The same of the next scan in a room, taken a little further on.
  std::vector<map_delta_t> Answer(MatchState state = MatchState::kOk, const AfterMatch& after = {}) {
    const auto k = static_cast<double>(history.size());
    const ScanMatch match{100 + version(), {0.03 * k, 0.01 * k, 0.0}, 0.9, 1, 1, version(), state};
    return Draw(AllRays(ScanRoom(match.T_map_laser, match.utime, 180)), match, after);
  }

  /// Changes a tile with the version that there is.
  void Change(const TileChange& change) {
    map.Apply(change);
    if (changed_in_.count(change.index) == 0) tiles_.push_back(change.index);
    changed_in_[change.index] = version();
  }

  map_page_t Page(const map_request_t& request) const {
    constexpr int kTilesInPage = 4;
    constexpr std::int64_t kMatchesInPage = 100;
    const bool same_map = request.epoch == epoch;
    map_page_t page{};
    page.request = request;
    page.epoch = epoch;
    page.version = version();
    page.cell_size_m = map.geometry().cell_size_m();
    page.next_match = -1;
    if (request.first_match >= 0) {
      const std::int64_t first = same_map ? std::min<std::int64_t>(request.first_match, version()) : 0;
      const std::int64_t end = std::min(version(), first + kMatchesInPage);
      for (auto i = first; i < end; ++i) page.matches.push_back(ToMessage(history[static_cast<std::size_t>(i)]));
      page.next_match = static_cast<std::int32_t>(end);
      if (end == version()) page.loops = loops;
      if (end == version()) page.marks = marks;
    }
    auto tile = same_map ? static_cast<std::size_t>(request.first_tile) : 0;
    for (; tile < tiles_.size() && page.tiles.size() < kTilesInPage; ++tile) {
      const TileIndex index = tiles_[tile];
      if (same_map && changed_in_.at(index) <= request.base_version) continue;
      page.tiles.push_back(
          ToMessage(TileChange{index, PackRuns(ByteMap::Tile().cells, map.tiles().Find(index)->cells)}));
    }
    page.next_tile = tile < tiles_.size() ? static_cast<std::int32_t>(tile) : -1;
    if (page.next_tile < 0) page.tracking = {ToMessage(tracking)};
    page.num_tiles = static_cast<std::int32_t>(page.tiles.size());
    page.num_matches = static_cast<std::int32_t>(page.matches.size());
    page.num_tracking = static_cast<std::int32_t>(page.tracking.size());
    page.num_loops = static_cast<std::int32_t>(page.loops.size());
    page.num_marks = static_cast<std::int32_t>(page.marks.size());
    return page;
  }

  scan_answer_t AnswerAbout(const scan_request_t& request) const {
    scan_answer_t answer{request.utime, epoch, request.requester, std::numeric_limits<std::int64_t>::max(), 0, {}};
    for (const ScanMatch& match : history) {
      if (match.utime > request.utime) answer.next_utime = std::min(answer.next_utime, match.utime);
    }
    for (const ScanMatch& match : history) {
      if (match.utime == request.utime) answer.matches = {ToMessage(match)};
    }
    answer.num_matches = static_cast<std::int32_t>(answer.matches.size());
    return answer;
  }

  /// Answers who asks on a bus.
  void Serve(Bus& bus) {
    bus.Subscribe<map_request_t>(kMapRequestChannel, [&](const map_request_t& request) {
      bus.Publish(request.whole == 1 ? kWholeMapChannel : kMapPageChannel, Page(request));
      ++num_pages;
    });
    bus.Subscribe<scan_request_t>(kScanRequestChannel, [&](const scan_request_t& request) {
      bus.Publish(kScanAnswerChannel, AnswerAbout(request));
    });
  }

  std::int64_t version() const { return std::ssize(history); }

  static constexpr double kCellSize_m = 0.02;  ///< the room is about forty tiles

  std::int64_t epoch = ++last_epoch;  ///< each owner begins a map of its own
  std::vector<ScanMatch> history;
  TrackingState tracking;
  std::vector<map_loop_t> loops;
  std::vector<placed_mark_t> marks;
  ByteMap map;  ///< what all deltas together make
  int num_pages = 0;

 private:
  static inline std::int64_t last_epoch = 0;

  static UpdateParameters FineParameters() {
    UpdateParameters parameters = TestParameters().update;
    parameters.cell_size_m = kCellSize_m;
    return parameters;
  }

  MapUpdater updater_;
  std::vector<TileIndex> tiles_;  ///< in the order of their creation
  std::map<TileIndex, std::int64_t> changed_in_;
};

}  // namespace crsm
