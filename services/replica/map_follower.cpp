#include "services/replica/map_follower.hpp"

namespace crsm {

MapFollower::MapFollower(Service& service, View view, Keeper keeper)
    : service_(service),
      replica_(DrawIdentity(),
               {std::move(keeper.begin),
                [this, apply = std::move(keeper.apply)](std::span<const TileChange> changes) {
                  if (!apply(changes)) CountRefused();
                },
                std::move(keeper.add)},
               view),
      stall_watch_(service.name(), Say) {
  service_.bus().SubscribeToOne<map_page_t>(view == View::kWhole ? kWholeMapChannel : kMapPageChannel, kMapOwnerRole,
                                            [this](const map_page_t& page) { Handle(page); });
}

void MapFollower::Handle(const map_page_t& page) {
  const std::int64_t num_forged_before = replica_.num_forged();
  replica_.Handle(page);
  if (replica_.num_forged() == num_forged_before) return;
  service_.Complain("pages_refused",
                    service_.name() +
                        ": map_updater answers MAP_REQUEST that this process did not send: another program "
                        "on this bus forges them. Their answers are ignored");
}

void MapFollower::CountRefused() {
  service_.Complain(
      "tiles_refused",
      service_.name() + ": the map has malformed tiles, or more tiles than a map may have; they are left out");
}

void MapFollower::Poll() {
  auto request = replica_.NextRequest();
  const auto now = Clock::now();
  stall_watch_.Look(
      request ? StallWatch::Awaited{"map_updater to answer MAP_REQUEST (the version here is {})", replica_.version()}
              : StallWatch::Awaited{},
      now);
  // A page that brings nothing new, an old one that comes late say, is no reason to ask at once: each such answer would
  // make the next question.
  if (request && request->question != std::exchange(last_question_, request->question)) backoff_.RestartAtOnce();
  if (!request || !backoff_.Due(now)) return;
  service_.counters().Add("map_requests");
  service_.bus().Publish(kMapRequestChannel, *request);
}

}  // namespace crsm
