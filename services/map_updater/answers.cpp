#include "services/map_updater/answers.hpp"

#include <algorithm>

#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

/// A message that grows, and its size on the wire.
struct Part {
  explicit Part(const map_delta_t& blank) : message(blank), size(static_cast<std::size_t>(blank.getEncodedSize())) {}

  void Add(const ScanMatch& match) { Append(ToMessage(match), message.matches, message.num_matches); }
  void Add(const MapPieces& pieces) { Append(ToMessage(pieces), message.layout, message.num_layouts); }
  void Add(const PlacedLoop& loop) { Append(ToMessage(loop), message.loops, message.num_loops); }
  void AddAsked(const ScanMatch& match) { Append(ToMessage(match), message.asked, message.num_asked); }
  void AddMotion(const Pose2& T_new_old) { Append(ToMessage(T_new_old), message.T_new_old, message.num_moved); }
  void Add(const TrackingState& tracking) { Append(ToMessage(tracking), message.tracking, message.num_tracking); }

  /// False, and nothing is added, if the message would be larger than `most_bytes`. The first tile always fits.
  bool Add(const TileChange& change, std::size_t most_bytes) {
    map_tile_t tile = ToMessage(change);
    const auto tile_size = static_cast<std::size_t>(tile._getEncodedSizeNoHash());
    if (message.num_tiles > 0 && size + tile_size > most_bytes) return false;
    Append(std::move(tile), message.tiles, message.num_tiles);
    return true;
  }

  template <class Item>
  void Append(Item item, std::vector<Item>& list, std::int32_t& count) {
    size += static_cast<std::size_t>(item._getEncodedSizeNoHash());
    list.push_back(std::move(item));
    ++count;
  }

  map_delta_t message;
  std::size_t size;
};

/// A message with nothing in it, the only part of its version.
map_delta_t MakeBlank(std::int64_t utime, std::int64_t version, std::int64_t base_version, const MapGeometry& geometry,
                      const AnswerOptions& options) {
  map_delta_t blank{};
  blank.utime = utime;
  blank.epoch = options.epoch;
  blank.version = version;
  blank.base_version = base_version;
  blank.cell_size_m = geometry.cell_size_m();
  blank.num_parts = 1;
  return blank;
}

/// The scans that are told, in their order.
class ToldScans {
 public:
  explicit ToldScans(const Answered& answered) : answered_(answered), size_(answered.matches.size()) {
    if (!answered.component) return;
    runs_ = answered.put_right->FindScans(*answered.component);
    size_ = answered.put_right->CountScans(*answered.component);
  }

  std::int64_t size() const { return size_; }

  /// As it was matched, or as it belongs on the map. index: 0 to size() - 1.
  ScanMatch At(std::int64_t index) const {
    if (!answered_.component) {
      const ScanMatch match = answered_.matches.At(index);
      return answered_.put_right ? answered_.put_right->BestMatch(index, match) : match;
    }
    auto run = runs_.begin();
    for (; index >= run->end - run->first; ++run) index -= run->end - run->first;
    const std::int64_t scan = run->first + index;
    return answered_.put_right->MoveToBest(scan, answered_.matches.At(scan));
  }

 private:
  const Answered& answered_;
  std::vector<Mapper::ScanRun> runs_;
  std::int64_t size_;
};

}  // namespace

std::vector<map_delta_t> MakeParts(const MapDelta& delta, const ScanMatch& match, const MapGeometry& geometry,
                                   const AnswerOptions& options, const AfterMatch& after) {
  const map_delta_t blank = MakeBlank(match.utime, delta.version, delta.version - 1, geometry, options);
  std::vector<map_delta_t> parts;
  Part part(blank);
  part.Add(match);
  if (after.T_new_old) part.AddMotion(*after.T_new_old);
  part.message.trajectory = after.trajectory;
  part.message.floating = after.floating ? 1 : 0;
  for (const TileChange& change : delta.tiles) {
    if (part.Add(change, options.most_bytes)) continue;
    parts.push_back(std::move(part.message));
    part = Part(blank);
    part.Add(change, options.most_bytes);
  }
  parts.push_back(std::move(part.message));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i].part = static_cast<std::int32_t>(i);
    parts[i].num_parts = static_cast<std::int32_t>(parts.size());
  }
  return parts;
}

map_delta_t MakeEmptyAnswer(std::int64_t utime, const MapUpdater& updater, const AnswerOptions& options) {
  return MakeBlank(utime, updater.version(), updater.version(), updater.geometry(), options);
}

map_delta_t MakePage(const map_request_t& asked, const MapUpdater& updater, const Answered& answered,
                     const AnswerOptions& options) {
  map_request_t request = asked;
  if (asked.epoch != options.epoch) {  // of another map: everything, from the start
    request.base_version = 0;
    request.first_tile = 0;
    request.first_match = std::min(asked.first_match, 0);
  }
  const auto recent = answered.tracking.recent();
  map_delta_t blank = MakeBlank(recent.empty() ? 0 : recent.back().utime, updater.version(), request.base_version,
                                updater.geometry(), options);
  blank.num_requests = 1;
  blank.request = {asked};
  Part page(blank);
  if (request.asked_utime >= 0) {
    if (const auto match = answered.matches.Find(request.asked_utime)) page.AddAsked(*match);
  }

  page.message.next_match = -1;
  if (request.first_match >= 0) {
    const ToldScans scans(answered);
    std::int64_t match = std::min<std::int64_t>(request.first_match, scans.size());
    for (; match < scans.size() && page.size < options.most_bytes / 2; ++match) page.Add(scans.At(match));
    page.message.next_match = static_cast<std::int32_t>(match);
    if (answered.put_right && !answered.component && match == scans.size()) {
      page.Add(answered.put_right->FindPieces());
      for (const PlacedLoop& loop : answered.put_right->PlaceLoops()) page.Add(loop);
    }
  }

  auto tile = static_cast<std::size_t>(request.first_tile);
  for (; tile < updater.num_tiles(); ++tile) {
    const auto change = updater.TileSince(tile, request.base_version);
    if (change && !page.Add(*change, options.most_bytes)) break;
  }
  const bool last = tile >= updater.num_tiles();
  page.message.next_tile = last ? -1 : static_cast<std::int32_t>(tile);
  if (last && !answered.component) page.Add(answered.tracking);
  return page.message;
}

}  // namespace crsm
