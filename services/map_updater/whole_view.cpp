#include "services/map_updater/whole_view.hpp"

#include <utility>

#include "services/runtime/map_replica.hpp"

namespace crsm {

void WholeView::Ask(const map_request_t& request, const Sender& sender) {
  std::erase_if(asked_, [&](const Asked& other) {
    return other.request.requester == request.requester && other.sender == sender &&
           (sender.known() || SameQuestion(other.request, request));
  });
  if (asked_.size() == kMostWaiting) asked_.erase(asked_.begin());
  asked_.push_back({request, sender});
}

void WholeView::Show(const Mapper& mapper, const Answered& answered, AnswerOptions options) {
  constexpr int kPiece = 10;  // scans: half a millisecond
  if (asked_.empty()) return;
  const bool loops = mapper.closes_loops();
  if (loops) {
    if (std::exchange(num_layouts_, mapper.num_layouts()) != mapper.num_layouts()) whole_.Forget();
    if (!whole_.Draw(mapper, kPiece)) return;
    options.epoch += num_layouts_;  // what was seen is elsewhere now: another map
  }
  const MapUpdater& map = loops ? whole_.map() : mapper.local();
  for (const Asked& asked : std::exchange(asked_, {})) {
    bus_.Publish(kWholeMapChannel, MakePage(asked.request, map,
                                            {answered.matches, answered.tracking, loops ? &mapper : nullptr}, options));
  }
}

}  // namespace crsm
