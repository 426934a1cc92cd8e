#include "services/map_updater/whole_view.hpp"

#include <utility>

#include "services/replica/map_replica.hpp"

namespace crsm {
namespace {

constexpr int kScansAtOnce = 10;  // half a millisecond

}  // namespace

void WholeView::Ask(const map_request_t& request, const Sender& sender) {
  std::erase_if(asked_, [&](const Asked& other) {
    return other.request.requester == request.requester && other.sender == sender &&
           (sender.known() || SameQuestion(other.request, request));
  });
  if (asked_.size() == kMostWaiting) asked_.erase(asked_.begin());
  asked_.push_back({request, sender});
}

void WholeView::Show(const Mapper& mapper, const Answered& answered, AnswerOptions options) {
  if (asked_.empty()) return;
  const std::int32_t piece = asked_.front().request.piece;
  if (!mapper.closes_loops()) {  // there are no pieces
    if (piece == 0) {
      AnswerWhoAskedFor(0, mapper.local(), {answered.matches, answered.tracking, nullptr, {}, answered.place_marks},
                        options);
    }
    std::erase_if(asked_, [&](const Asked& asked) { return asked.request.piece == piece; });
    return;
  }
  if (std::exchange(num_layouts_, mapper.num_layouts()) != mapper.num_layouts()) {
    whole_.Forget();
    component_.reset();
  }
  options.epoch += num_layouts_;  // what was seen is elsewhere now: another map
  if (piece != 0) return ShowPiece(piece, mapper, answered, options);
  if (!whole_.Draw(mapper, kScansAtOnce)) return;
  AnswerWhoAskedFor(0, whole_.map(),
                    {answered.matches, answered.tracking, &mapper, {}, answered.place_marks, &map_error_}, options);
}

/// A piece is a map of its own: with its own epoch, and as many versions as it has scans. One that is not there has
/// none.
void WholeView::ShowPiece(std::int32_t piece, const Mapper& mapper, const Answered& answered, AnswerOptions options) {
  const int component = mapper.FindComponent(piece);
  if (component_ != component) piece_.Forget();
  component_ = component;
  if (!piece_.Draw(mapper, component, mapper.CountScans(component), kScansAtOnce)) return;
  options.epoch ^= (std::int64_t{component} + 2) << 32;
  AnswerWhoAskedFor(piece, piece_.map(), {answered.matches, answered.tracking, &mapper, component}, options);
}

void WholeView::AnswerWhoAskedFor(std::int32_t piece, const MapUpdater& map, const Answered& answered,
                                  const AnswerOptions& options) {
  for (const Asked& asked : asked_) {
    if (asked.request.piece != piece) continue;
    bus_.Publish(kWholeMapChannel, MakePage(asked.request, map, answered, options));
  }
  std::erase_if(asked_, [&](const Asked& asked) { return asked.request.piece == piece; });
}

}  // namespace crsm
