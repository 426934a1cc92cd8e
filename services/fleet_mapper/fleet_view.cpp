#include "services/fleet_mapper/fleet_view.hpp"

#include <algorithm>
#include <utility>

#include "services/replica/map_replica.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

constexpr int kKeyframesAtOnce = 20;  // a millisecond or two

using Page = GrowingMessage<map_page_t>;

}  // namespace

void FleetView::Ask(const map_request_t& request, const Sender& sender) {
  std::erase_if(asked_, [&](const Asked& other) {
    return other.request.requester == request.requester && other.sender == sender &&
           (sender.known() || SameQuestion(other.request, request));
  });
  if (asked_.size() == kMostWaiting) asked_.erase(asked_.begin());
  asked_.push_back({request, sender});
}

void FleetView::Look() {
  for (std::size_t i = utimes_.size(); i < fleet_.keyframes().size(); ++i) {
    const FleetKeyframeId& at = fleet_.keyframes()[i];
    const std::int64_t utime = fleet_.graph().map(at.map).keyframe(at.id).utime;
    unique_.BeginDrive();
    utimes_.push_back(unique_.Add(utime).value_or(utime));
  }
  std::vector<int> pieces = SortPieces(fleet_.graph());
  const bool is_another_shown = !pieces_.empty() && pieces_.front() != pieces.front();
  pieces_ = std::move(pieces);
  const bool has_moved = std::exchange(num_layouts_, fleet_.graph().num_layouts()) != fleet_.graph().num_layouts();
  if (!is_another_shown && !has_moved) return;
  ++layout_;
  whole_.Forget();
  piece_.Forget();
}

std::vector<map_page_t> FleetView::Answer(const AnswerOptions& options) {
  if (asked_.empty()) return {};
  Look();
  const std::int32_t piece = asked_.front().request.piece;
  AnswerOptions of_layout = options;
  of_layout.epoch += layout_;
  std::optional<int> only;
  if (piece != 0) {
    only = piece <= std::ssize(pieces_) ? pieces_[static_cast<std::size_t>(piece) - 1] : -1;
    if (drawn_piece_ != only) piece_.Forget();
    drawn_piece_ = only;
    of_layout.epoch ^= (std::int64_t{*only} + 2) << 32;
  }
  const Told told{only ? piece_ : whole_, only, std::ssize(ListKeyframes(only))};
  const int drawn = only.value_or(pieces_.empty() ? -1 : pieces_.front());
  if (!told.drawing.Draw(fleet_, clock_, drawn, told.version, kKeyframesAtOnce)) return {};
  std::vector<map_page_t> pages;
  for (const Asked& asked : asked_) {
    if (asked.request.piece == piece) pages.push_back(MakePage(asked.request, told, of_layout));
  }
  std::erase_if(asked_, [&](const Asked& asked) { return asked.request.piece == piece; });
  return pages;
}

/// Those that are told, as places in the order of all.
std::vector<std::size_t> FleetView::ListKeyframes(std::optional<int> only) const {
  std::vector<std::size_t> keyframes;
  for (std::size_t i = 0; i < fleet_.keyframes().size(); ++i) {
    if (!only || fleet_.graph().piece(fleet_.keyframes()[i]) == *only) keyframes.push_back(i);
  }
  return keyframes;
}

map_page_t FleetView::MakePage(const map_request_t& request, const Told& told, const AnswerOptions& options) {
  map_page_t blank{};
  blank.request = request;
  blank.epoch = options.epoch;
  blank.version = told.version;
  blank.cell_size_m = told.drawing.map().geometry().cell_size_m();
  blank.next_match = -1;
  Page page(blank);
  const bool same_map = request.epoch == options.epoch;  // else everything, from the start
  if (request.first_match >= 0) {
    const std::vector<std::size_t> keyframes = ListKeyframes(told.only);
    std::size_t next = std::min(same_map ? static_cast<std::size_t>(request.first_match) : 0, keyframes.size());
    for (; next < keyframes.size() && page.size < options.most_bytes / 2; ++next) {
      page.Add(ToMessage(MakeMatch(keyframes[next], told.drawing)), page.message.matches, page.message.num_matches);
    }
    page.message.next_match = static_cast<std::int32_t>(next);
    if (next == keyframes.size() && !told.only) {
      for (const PlacedMark& mark : marks_.Place(fleet_.graph(), pieces_.empty() ? -1 : pieces_.front())) {
        page.Add(ToMessage(mark), page.message.marks, page.message.num_marks);
      }
      page.Add(ToMessage(FindLayout(request.settled == 1)), page.message.layout, page.message.num_layouts);
      for (const PlacedLoop& loop : PlaceLoops(fleet_.graph(), pieces_.empty() ? -1 : pieces_.front())) {
        page.Add(ToMessage(loop), page.message.loops, page.message.num_loops);
      }
    }
  }
  const MapUpdater& map = told.drawing.map();
  std::size_t tile = same_map ? static_cast<std::size_t>(request.first_tile) : 0;
  for (; tile < map.num_tiles(); ++tile) {
    const auto change = map.TileSince(tile, same_map ? request.base_version : 0);
    if (change && !page.AddTile(*change, options.most_bytes)) break;
  }
  page.message.next_tile = tile >= map.num_tiles() ? -1 : static_cast<std::int32_t>(tile);
  return std::move(page.message);
}

/// settled: who asks wants what is known in the end.
MapPieces FleetView::FindLayout(bool settled) {
  MapPieces layout = DescribePieces(fleet_, pieces_);
  if (pieces_.empty()) return layout;
  const auto Collect = [&] { return fleet_.graph().CollectMotions(pieces_.front()); };
  layout.error = settled ? EstimateMapError(Collect()) : map_error_.Find(Collect);
  return layout;
}

ScanMatch FleetView::MakeMatch(std::size_t keyframe, FleetDrawing& drawing) const {
  const FleetKeyframeId& at = fleet_.keyframes()[keyframe];
  const FleetGraph& graph = fleet_.graph();
  const Keyframe& scan = graph.map(at.map).keyframe(at.id);
  ScanMatch match;
  match.utime = utimes_[keyframe];
  match.T_map_laser = graph.pose(at);
  match.fitness = drawing.ComputeAgreement(fleet_, at);
  match.map_version = static_cast<std::int64_t>(keyframe);
  match.state = at.id.number == 0 ? MatchState::kFirst : MatchState::kOk;
  if (scan.degenerate_axis && at.id.number > 0) {
    match.state = MatchState::kDegenerate;
    match.degenerate_axis = TurnAxis(*scan.degenerate_axis, match.T_map_laser.yaw_rad);
  }
  match.num_critical = static_cast<std::int32_t>(scan.rays.size());
  match.trajectory = graph.TrajectoryOf(at);
  match.floating = !pieces_.empty() && graph.piece(at) != pieces_.front();
  return match;
}

}  // namespace crsm
