#include "services/replica/matched_map.hpp"

#include <utility>

namespace crsm {

MatchedMap::MatchedMap(Service& service, MapFollower::Keeper keeper)
    : service_(service),
      requester_(DrawIdentity()),
      pages_(service, MapFollower::View::kMatched, std::move(keeper)),
      deltas_(pages_.replica()),
      stall_watch_(service.name(), Say) {
  Bus& bus = service.bus();
  bus.SubscribeToOne<map_delta_t>(kMapDeltaChannel, kMapOwnerRole,
                                  [this](const map_delta_t& part) { deltas_.Handle(part); });
  bus.SubscribeToOne<scan_answer_t>(kScanAnswerChannel, kMapOwnerRole, [this](const scan_answer_t& answer) {
    if (answer.epoch != replica().epoch()) return RequestUpdate();
    question_epoch_ = answer.epoch;
    question_.Handle(answer);
  });
}

void MatchedMap::Poll() {
  pages_.Poll();
  const auto asked = question_.asked();
  const auto now = Clock::now();
  stall_watch_.Look(
      asked ? StallWatch::Awaited{"map_updater to answer SCAN_REQUEST of scan {}", *asked} : StallWatch::Awaited{},
      now);
  if (asked && std::exchange(last_asked_, asked) != asked) backoff_.RestartAtOnce();
  if (!asked || !backoff_.Due(now)) return;
  service_.counters().Add("scan_requests");
  service_.bus().Publish(kScanRequestChannel, scan_request_t{*asked, requester_});
}

}  // namespace crsm
