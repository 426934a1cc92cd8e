#include "services/runtime/map_replica.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "services/runtime/conversions.hpp"

namespace crsm {
namespace {

std::vector<TileChange> Changes(const map_delta_t& delta) {
  std::vector<TileChange> changes;
  for (const map_tile_t& tile : delta.tiles) changes.push_back(FromMessage(tile));
  return changes;
}

std::size_t NumTilesAndMatches(const std::map<std::int32_t, map_delta_t>& parts) {
  std::size_t num = 0;
  for (const auto& [number, part] : parts) num += part.tiles.size() + part.matches.size();
  return num;
}

}  // namespace

MapReplica::MapReplica(std::int64_t requester, ApplyChanges apply, Clear clear)
    : requester_(requester), apply_(std::move(apply)), clear_(std::move(clear)) {}

void MapReplica::Handle(const map_delta_t& delta) {
  if (delta.recipient == 0) {
    HandleBroadcast(delta);
  } else if (delta.recipient == requester_) {
    HandlePage(delta);
  }
}

std::optional<map_request_t> MapReplica::NextRequest() const {
  if (synced_) return std::nullopt;
  map_request_t request;
  request.requester = requester_;
  request.epoch = epoch_;
  request.base_version = version_;
  request.first_tile = next_tile_;
  request.first_match = static_cast<std::int32_t>(matches_.size());
  return request;
}

void MapReplica::HandleBroadcast(const map_delta_t& delta) {
  if (delta.epoch == epoch_ && delta.version == version_ && synced_) return;  // the last answer, sent again
  if (delta.epoch != epoch_ || delta.version != version_ + 1 || delta.base_version != version_) {
    synced_ = false;  // a version was missed, or the owner began anew
    return;
  }
  if (!synced_) return;  // pages are under way and will bring it
  if (!parts_.empty() && parts_.begin()->second.num_parts != delta.num_parts) parts_.clear();
  parts_[delta.part] = delta;
  if (NumTilesAndMatches(parts_) > kMostTiles) {  // not the owner's: no map has so many
    parts_.clear();
    synced_ = false;
    return;
  }
  if (static_cast<std::int32_t>(parts_.size()) < delta.num_parts) return;

  for (const auto& [number, part] : parts_) {
    apply_(Changes(part));
    for (const scan_match_t& match : part.matches) matches_.push_back(FromMessage(match));
  }
  parts_.clear();
  ++version_;
  if (static_cast<std::int64_t>(matches_.size()) != version_) Reset();  // not the owner's: begin again
}

void MapReplica::HandlePage(const map_delta_t& page) {
  if (page.epoch != epoch_) {
    if (epoch_ != 0) Reset();
    epoch_ = page.epoch;
  }
  cell_size_m_ = page.cell_size_m;
  if (synced_ || page.base_version != version_) return;  // an answer to an earlier question
  // Older than what was heard of this map already: a power cut took the end of the owner's journal.
  const auto newest_heard = std::max(static_cast<std::int64_t>(matches_.size()), pages_version_.value_or(0));
  if (page.version < newest_heard) return Reset();
  if (!pages_version_) pages_version_ = page.version;

  // A page asked for twice comes twice; tiles are whole, so that applying one again does no harm.
  const auto first_match = static_cast<std::int64_t>(page.next_match) - page.num_matches;
  if (first_match != static_cast<std::int64_t>(matches_.size())) return;
  apply_(Changes(page));
  for (const scan_match_t& match : page.matches) matches_.push_back(FromMessage(match));
  next_tile_ = page.next_tile >= 0 ? page.next_tile : std::numeric_limits<std::int32_t>::max();
  if (page.next_tile >= 0 || page.next_match < page.version) return;

  // All tiles were seen once. Those that changed meanwhile are asked for again, from where this round began.
  version_ = *std::exchange(pages_version_, std::nullopt);
  next_tile_ = 0;
  parts_.clear();
  synced_ = version_ == page.version;
}

void MapReplica::Reset() {
  clear_();
  synced_ = false;
  version_ = 0;
  matches_.clear();
  next_tile_ = 0;
  pages_version_.reset();
  parts_.clear();
}

}  // namespace crsm
