#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "common/map/map_delta.hpp"
#include "common/scan/scan_match.hpp"
#include "services/runtime/wire.hpp"

namespace crsm {

/// A copy of the map that another process owns, kept whole over a network that loses messages.
///
/// Deltas for everybody lead from one version to the next and are applied when all their parts are there. When one is
/// missing, and at the start, the replica asks the owner page by page (MAP_REQUEST) until it holds a whole version
/// again. Of which map the versions are says their epoch: when a delta has another, the owner is asked, and when it has
/// begun a new map, the replica does too. It touches neither network nor clock: messages go in, and NextRequest says
/// what to send.
class MapReplica {
 public:
  using ApplyChanges = std::function<void(std::span<const TileChange>)>;
  using Clear = std::function<void()>;

  /// requester: a number of this replica's own, not 0. apply: takes over changed tiles. clear: drops all tiles, because
  /// the owner has begun a new map.
  MapReplica(std::int64_t requester, ApplyChanges apply, Clear clear);

  void Handle(const map_delta_t& delta);

  /// Whether a whole version is held, so far as the replica knows.
  bool synced() const { return synced_; }
  /// Of the map that is held; 0 before the owner was heard.
  std::int64_t epoch() const { return epoch_; }
  std::int64_t version() const { return version_; }
  /// All matches that the owner has answered, oldest first; as many as `version` when synced.
  const std::vector<ScanMatch>& matches() const { return matches_; }
  /// Side of a cell [m]; 0 before the owner was heard.
  double cell_size_m() const { return cell_size_m_; }

  /// Doubts that the version held is the last: the owner is to be asked.
  void Doubt() { synced_ = false; }

  /// What to ask the owner; nothing when synced.
  std::optional<map_request_t> NextRequest() const;

 private:
  void HandlePage(const map_delta_t& page);
  void HandleBroadcast(const map_delta_t& delta);
  void Reset();

  std::int64_t requester_;
  ApplyChanges apply_;
  Clear clear_;

  bool synced_ = false;
  std::int64_t epoch_ = 0;
  std::int64_t version_ = 0;
  std::vector<ScanMatch> matches_;
  double cell_size_m_ = 0.0;

  std::int32_t next_tile_ = 0;                 ///< of the pages under way
  std::optional<std::int64_t> pages_version_;  ///< the owner's when the first of them came
  std::map<std::int32_t, map_delta_t> parts_;  ///< of version + 1, by number; together no larger than a map
};

}  // namespace crsm
