#include "services/map_updater/pages.hpp"

#include <algorithm>

namespace crsm {
namespace {

using Page = GrowingMessage<map_page_t>;

/// The scans that are told, in their order.
class ToldScans {
 public:
  explicit ToldScans(const Answered& answered) : answered_(answered), size_(answered.matches.size()) {
    if (!answered.component) return;
    runs_ = answered.corrected->FindScans(*answered.component);
    size_ = answered.corrected->CountScans(*answered.component);
  }

  std::int64_t size() const { return size_; }

  /// As it was matched, or as it belongs on the map. index: 0 to size() - 1.
  ScanMatch At(std::int64_t index) const {
    const std::int64_t scan = answered_.component ? ScanOf(index) : index;
    const ScanMatch match = answered_.matches.At(scan);
    return answered_.corrected ? answered_.corrected->BestMatch(scan, match) : match;
  }

 private:
  /// Of the component.
  std::int64_t ScanOf(std::int64_t index) const {
    auto run = runs_.begin();
    for (; index >= run->end - run->first; ++run) index -= run->end - run->first;
    return run->first + index;
  }

  const Answered& answered_;
  std::vector<Mapper::ScanRun> runs_;
  std::int64_t size_;
};

MapPieces FindLayout(const Answered& answered, bool settled) {
  if (settled) return answered.corrected->FindPiecesAndError();
  MapPieces pieces = answered.corrected->FindPiecesAndSlip();
  if (answered.map_error) {
    pieces.error = answered.map_error->Find([&] { return answered.corrected->CollectMotions(); });
  }
  return pieces;
}

/// Matches from `first` on, and what comes with the last of them. settled: who asks wants what is known in the end.
void AddMatches(std::int32_t first, bool settled, const Answered& answered, std::size_t most_bytes, Page& page) {
  const ToldScans scans(answered);
  std::int64_t next = std::min<std::int64_t>(first, scans.size());
  for (; next < scans.size() && page.size < most_bytes; ++next) {
    page.Add(ToMessage(scans.At(next)), page.message.matches, page.message.num_matches);
  }
  page.message.next_match = static_cast<std::int32_t>(next);
  if (answered.component || next < scans.size()) return;
  for (const PlacedMark& mark : answered.place_marks()) {
    page.Add(ToMessage(mark), page.message.marks, page.message.num_marks);
  }
  if (!answered.corrected) return;
  page.Add(ToMessage(FindLayout(answered, settled)), page.message.layout, page.message.num_layouts);
  for (const PlacedLoop& loop : answered.corrected->PlaceLoops()) {
    page.Add(ToMessage(loop), page.message.loops, page.message.num_loops);
  }
}

/// Tiles from `first` on, and what comes with the last of them.
void AddTiles(std::int32_t first, std::int64_t base_version, const MapUpdater& updater, const Answered& answered,
              std::size_t most_bytes, Page& page) {
  auto tile = static_cast<std::size_t>(first);
  for (; tile < updater.num_tiles(); ++tile) {
    const auto change = updater.TileSince(tile, base_version);
    if (change && !page.AddTile(*change, most_bytes)) break;
  }
  const bool last = tile >= updater.num_tiles();
  page.message.next_tile = last ? -1 : static_cast<std::int32_t>(tile);
  if (last && !answered.component) {
    page.Add(ToMessage(answered.tracking), page.message.tracking, page.message.num_tracking);
  }
}

}  // namespace

map_page_t MakePage(const map_request_t& request, const MapUpdater& updater, const Answered& answered,
                    const AnswerOptions& options) {
  map_page_t blank{};
  blank.request = request;
  blank.epoch = options.epoch;
  blank.version = updater.version();
  blank.cell_size_m = updater.geometry().cell_size_m();
  blank.next_match = -1;
  Page page(blank);
  const bool same_map = request.epoch == options.epoch;  // else everything, from the start
  if (request.first_match >= 0) {
    AddMatches(same_map ? request.first_match : 0, request.settled == 1, answered, options.most_bytes / 2, page);
  }
  AddTiles(same_map ? request.first_tile : 0, same_map ? request.base_version : 0, updater, answered,
           options.most_bytes, page);
  return std::move(page.message);
}

}  // namespace crsm
