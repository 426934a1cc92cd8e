#include "services/replica/map_replica.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

std::vector<TileChange> Changes(const map_delta_t& delta) {
  std::vector<TileChange> changes;
  for (const map_tile_t& tile : delta.tiles) changes.push_back(FromMessage(tile));
  return changes;
}

/// What the match of this delta has brought about.
AfterMatch AfterMatchOf(const map_delta_t& delta) {
  return {delta.T_new_old.empty() ? std::nullopt : std::optional(FromMessage(delta.T_new_old.front())),
          delta.trajectory, delta.floating == 1};
}

std::size_t NumTilesAndMatches(const std::map<std::int32_t, map_delta_t>& parts) {
  std::size_t num = 0;
  for (const auto& [number, part] : parts) num += part.tiles.size() + part.matches.size();
  return num;
}

}  // namespace

bool SameQuestion(const map_request_t& one, const map_request_t& other) {
  return one.requester == other.requester && one.epoch == other.epoch && one.base_version == other.base_version &&
         one.first_tile == other.first_tile && one.first_match == other.first_match &&
         one.asked_utime == other.asked_utime && one.whole == other.whole && one.settled == other.settled &&
         one.piece == other.piece;
}

MapReplica::MapReplica(std::int64_t requester, Keeper keeper, View view)
    : requester_(requester), keeper_(std::move(keeper)), view_(view) {}

void MapReplica::Handle(const map_delta_t& delta) {
  if (delta.num_requests == 0) {
    HandleBroadcast(delta);
  } else if (delta.request.front().requester == requester_ && Answers(delta.request.front())) {
    HandlePage(delta);
  }
}

std::optional<map_request_t> MapReplica::NextRequest() {
  auto request = Question();
  if (request && !SameQuestion(*request, asked_)) {
    ++request->question;
    asked_ = *request;
  }
  return request;
}

/// What the replica lacks, under the number of the last question.
std::optional<map_request_t> MapReplica::Question() const {
  if (synced_ && asked_utime_ < 0) return std::nullopt;
  map_request_t request{};
  request.requester = requester_;
  request.question = asked_.question;
  request.epoch = epoch_;
  request.base_version = version_;
  request.first_tile = next_tile_;
  request.first_match = wants_matches() ? static_cast<std::int32_t>(num_matches_) : -1;
  request.asked_utime = asked_utime_;
  request.whole = view_ == View::kWhole ? 1 : 0;
  request.settled = settled_ ? 1 : 0;
  request.piece = piece_;
  return request;
}

/// Whether a page for this request is what the replica waits for. An earlier question may be answered twice; one that
/// it never asked is somebody else's.
bool MapReplica::Answers(const map_request_t& request) {
  if (request.question < asked_.question) return false;
  if (request.question > asked_.question || !SameQuestion(request, asked_)) {
    ++num_forged_;
    return false;
  }
  const auto question = Question();
  return question && SameQuestion(*question, request);
}

void MapReplica::AskAbout(std::int64_t utime) {
  if (asked_utime_ == utime || AnswerAbout(utime)) return;
  asked_utime_ = utime;
  answer_.reset();
}

const MapReplica::Answer* MapReplica::AnswerAbout(std::int64_t utime) const {
  return answer_ && answer_->utime == utime ? &*answer_ : nullptr;
}

void MapReplica::HandleBroadcast(const map_delta_t& delta) {
  if (delta.epoch == epoch_ && delta.cell_size_m != cell_size_m_) return;  // not the owner's: a map keeps its cells
  if (delta.epoch == epoch_ && delta.version == version_ && synced_) {     // the last answer, sent again
    // ... or what was held is not the owner's.
    if (delta.base_version != version_ && delta.utime != version_utime_) Begin(epoch_, cell_size_m_);
    return;
  }
  if (delta.epoch == epoch_) heard_version_ = std::max(heard_version_, delta.version);
  if (delta.epoch != epoch_ || delta.version != version_ + 1 || delta.base_version != version_) {
    synced_ = false;  // a version was missed, or the owner began anew
    return;
  }
  if (!whole_) return;  // pages are under way and will bring it
  if (!parts_.empty() && parts_.begin()->second.num_parts != delta.num_parts) parts_.clear();
  parts_[delta.part] = delta;
  if (NumTilesAndMatches(parts_) > kMostTiles) {  // not the owner's: no map has so many
    parts_.clear();
    synced_ = false;
    return;
  }
  if (static_cast<std::int32_t>(parts_.size()) == delta.num_parts) ApplyParts();
}

/// All parts of the next version are there.
void MapReplica::ApplyParts() {
  const std::int64_t utime = parts_.begin()->second.utime;
  for (const auto& [number, part] : parts_) {
    keeper_.apply(Changes(part));
    for (const scan_match_t& message : part.matches) {
      const ScanMatch match = FromMessage(message);
      wants_matches() ? keeper_.add(match) : tracking_.Add(match, AfterMatchOf(part));
      ++num_matches_;
    }
  }
  parts_.clear();
  ++version_;
  version_utime_ = utime;
  synced_ = version_ >= heard_version_;
  if (num_matches_ != version_) Begin(epoch_, cell_size_m_);  // not the owner's: begin again
}

void MapReplica::HandlePage(const map_delta_t& page) {
  if (page.epoch != epoch_) Begin(page.epoch, page.cell_size_m);
  if (page.cell_size_m != cell_size_m_) return;  // not the owner's: a map keeps its cells
  if (asked_utime_ >= 0) {
    answer_ = Answer{std::exchange(asked_utime_, -1), std::nullopt};
    if (!page.asked.empty()) answer_->match = FromMessage(page.asked.front());
  }
  if (synced_ || page.base_version != version_) return;
  // Older than what was heard of this map already: a power cut took the end of the owner's journal.
  if (page.version < std::max(num_matches_, pages_version_.value_or(0))) return Begin(epoch_, cell_size_m_);
  if (!pages_version_) pages_version_ = page.version;
  whole_ = false;

  // A page asked for twice comes twice; tiles are whole, so that applying one again does no harm.
  if (!TakeMatches(page)) return;
  keeper_.apply(Changes(page));
  next_tile_ = page.next_tile >= 0 ? page.next_tile : std::numeric_limits<std::int32_t>::max();
  if (page.next_tile >= 0 || (wants_matches() && page.next_match < page.version)) return;

  // All tiles were seen once. Those that changed meanwhile are asked for again, from where this round began.
  version_ = *std::exchange(pages_version_, std::nullopt);
  version_utime_ = page.utime;
  next_tile_ = 0;
  parts_.clear();
  synced_ = whole_ = version_ == page.version;
}

/// What a page says of the matches. False if it is not what was asked for.
bool MapReplica::TakeMatches(const map_delta_t& page) {
  if (!wants_matches()) {
    if (page.next_tile >= 0) return true;  // the tracking state comes with the last page
    if (page.tracking.empty() || page.tracking.front().num_scans != page.version) return false;
    tracking_ = FromMessage(page.tracking.front());
    num_matches_ = tracking_.num_scans();
    return true;
  }
  if (static_cast<std::int64_t>(page.next_match) - page.num_matches != num_matches_) return false;
  for (const scan_match_t& match : page.matches) keeper_.add(FromMessage(match));
  num_matches_ += page.num_matches;
  if (!page.tracking.empty()) tracking_ = FromMessage(page.tracking.front());
  if (page.next_match < page.version) return true;
  loops_.clear();
  for (const map_loop_t& loop : page.loops) loops_.push_back(FromMessage(loop));
  pieces_.reset();
  if (!page.layout.empty()) pieces_ = FromMessage(page.layout.front());
  return true;
}

void MapReplica::Begin(std::int64_t epoch, double cell_size_m) {
  epoch_ = epoch;
  cell_size_m_ = cell_size_m;
  keeper_.begin(cell_size_m);
  synced_ = whole_ = false;
  heard_version_ = 0;
  version_ = 0;
  num_matches_ = 0;
  tracking_ = TrackingState();
  loops_.clear();
  pieces_.reset();
  next_tile_ = 0;
  pages_version_.reset();
  parts_.clear();
}

}  // namespace crsm
