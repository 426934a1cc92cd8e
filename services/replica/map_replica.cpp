#include "services/replica/map_replica.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "services/wire/conversions.hpp"

namespace crsm {

bool SameQuestion(const map_request_t& one, const map_request_t& other) {
  return one.requester == other.requester && one.epoch == other.epoch && one.base_version == other.base_version &&
         one.first_tile == other.first_tile && one.first_match == other.first_match && one.whole == other.whole &&
         one.settled == other.settled && one.piece == other.piece;
}

MapReplica::MapReplica(std::int64_t requester, Keeper keeper, View view) : keeper_(std::move(keeper)) {
  lacking_.requester = requester;
  lacking_.first_match = wants_matches() ? 0 : -1;
  lacking_.whole = view == View::kWhole ? 1 : 0;
}

std::optional<map_request_t> MapReplica::NextRequest() {
  if (synced_) return std::nullopt;
  if (!SameQuestion(lacking_, asked_)) {
    ++lacking_.question;
    asked_ = lacking_;
  }
  return lacking_;
}

/// Whether a page for this request is what the replica waits for. An earlier question may be answered twice; one that
/// it never asked is somebody else's.
bool MapReplica::Answers(const map_request_t& request) {
  if (request.requester != lacking_.requester || request.question < asked_.question) return false;
  if (request.question > asked_.question || !SameQuestion(request, asked_)) {
    ++num_forged_;
    return false;
  }
  return !synced_ && SameQuestion(request, lacking_);
}

void MapReplica::Handle(const map_page_t& page) {
  if (!Answers(page.request)) return;
  if (page.epoch != epoch()) Begin(page.epoch, page.cell_size_m);
  if (page.cell_size_m != cell_size_m_) return;  // not the owner's: a map keeps its cells
  // Older than what was heard of this map already: a power cut took the end of the owner's journal.
  if (page.version < std::max(num_matches(), pages_version_.value_or(0))) return BeginAgain();
  if (!pages_version_) pages_version_ = page.version;
  whole_ = false;

  // A page asked for twice comes twice; tiles are whole, so that applying one again does no harm.
  if (!(wants_matches() ? TakeMatches(page) : TakeTracking(page))) return;
  std::vector<TileChange> changes;
  for (const map_tile_t& tile : page.tiles) changes.push_back(FromMessage(tile));
  keeper_.apply(changes);
  lacking_.first_tile = page.next_tile >= 0 ? page.next_tile : std::numeric_limits<std::int32_t>::max();
  if (page.next_tile >= 0 || (wants_matches() && page.next_match < page.version)) return;

  // All tiles were seen once. Those that changed meanwhile are asked for again, from where this round began.
  lacking_.base_version = *std::exchange(pages_version_, std::nullopt);
  lacking_.first_tile = 0;
  synced_ = whole_ = version() == page.version;
}

/// It comes with the last page. False if it is not what was asked for.
bool MapReplica::TakeTracking(const map_page_t& page) {
  if (page.next_tile >= 0) return true;
  if (page.tracking.empty() || page.tracking.front().num_scans != page.version) return false;
  tracking_ = FromMessage(page.tracking.front());
  return true;
}

/// Matches, and what the last page says of them all. False if they are not what was asked for.
bool MapReplica::TakeMatches(const map_page_t& page) {
  if (std::int64_t{page.next_match} - page.num_matches != lacking_.first_match) return false;
  for (const scan_match_t& match : page.matches) keeper_.add(FromMessage(match));
  lacking_.first_match = page.next_match;
  if (!page.tracking.empty()) tracking_ = FromMessage(page.tracking.front());
  if (page.next_match < page.version) return true;
  loops_.clear();
  for (const map_loop_t& loop : page.loops) loops_.push_back(FromMessage(loop));
  marks_.clear();
  for (const placed_mark_t& mark : page.marks) marks_.push_back(FromMessage(mark));
  pieces_.reset();
  if (!page.layout.empty()) pieces_ = FromMessage(page.layout.front());
  return true;
}

void MapReplica::EndVersion(const ScanMatch& match, const AfterMatch& after) {
  tracking_.Add(match, after);
  ++lacking_.base_version;
  synced_ = version() >= heard_version_;
}

void MapReplica::Begin(std::int64_t epoch, double cell_size_m) {
  lacking_.epoch = epoch;
  lacking_.base_version = 0;
  lacking_.first_tile = 0;
  lacking_.first_match = wants_matches() ? 0 : -1;
  cell_size_m_ = cell_size_m;
  keeper_.begin(cell_size_m);
  synced_ = whole_ = false;
  heard_version_ = 0;
  pages_version_.reset();
  tracking_ = TrackingState();
  loops_.clear();
  marks_.clear();
  pieces_.reset();
}

}  // namespace crsm
