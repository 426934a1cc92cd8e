#include "services/map_updater/whole_view.hpp"

#include <utility>

namespace crsm {

void WholeView::Ask(const map_request_t& request) {
  std::erase_if(requests_, [&](const map_request_t& other) { return other.requester == request.requester; });
  requests_.push_back(request);
}

void WholeView::Show(const Mapper& mapper, const Answered& answered, AnswerOptions options) {
  constexpr int kPiece = 10;  // scans: half a millisecond
  if (requests_.empty()) return;
  const bool loops = mapper.closes_loops();
  if (loops) {
    if (std::exchange(num_updates_, mapper.num_updates()) != mapper.num_updates()) whole_.Forget();
    if (!whole_.Draw(mapper.graph(), mapper.best_poses(), mapper.local().version(), kPiece)) return;
    options.epoch += num_updates_;  // what was seen is elsewhere now: another map
  }
  const MapUpdater& map = loops ? whole_.map() : mapper.local();
  for (const map_request_t& request : std::exchange(requests_, {})) {
    bus_.Publish(kWholeMapChannel,
                 MakePage(request, map, {answered.matches, answered.tracking, loops ? &mapper : nullptr}, options));
  }
}

}  // namespace crsm
