#include "services/runtime/map_follower.hpp"

namespace crsm {
namespace {

bool SameQuestion(const map_request_t& one, const map_request_t& other) {
  return one.epoch == other.epoch && one.base_version == other.base_version && one.first_tile == other.first_tile &&
         one.first_match == other.first_match && one.asked_utime == other.asked_utime;
}

}  // namespace

MapFollower::MapFollower(Service& service, View view, Keeper keeper)
    : service_(service),
      view_(view),
      replica_(DrawIdentity(), {std::move(keeper.begin),
                                [this, apply = std::move(keeper.apply)](std::span<const TileChange> changes) {
                                  if (!apply(changes)) CountRefused();
                                },
                                std::move(keeper.add)}),
      stall_watch_(service.name(), Say) {
  service_.bus().SubscribeToOne<map_delta_t>(view == View::kWhole ? kWholeMapChannel : kMapDeltaChannel,
                                             [this](const map_delta_t& delta) { replica_.Handle(delta); });
}

void MapFollower::AwaitSettled() {
  settled_ = true;
  replica_.AskAs(DrawIdentity());  // what was asked for before is answered too early
  replica_.Doubt();
}

void MapFollower::CountRefused() {
  service_.Complain(
      "tiles_refused",
      service_.name() + ": a MAP_DELTA has malformed tiles, or more tiles than a map may have; they are left out");
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
  if (request && !(last_request_ && SameQuestion(*request, *last_request_))) backoff_.RestartAtOnce();
  if (!request || !backoff_.Due(now)) return;
  request->whole = view_ == View::kWhole ? 1 : 0;
  request->settled = settled_ ? 1 : 0;
  last_request_ = request;
  service_.counters().Add("map_requests");
  service_.bus().Publish(kMapRequestChannel, *request);
}

}  // namespace crsm
