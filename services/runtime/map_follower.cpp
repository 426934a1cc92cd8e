#include "services/runtime/map_follower.hpp"

namespace crsm {

MapFollower::MapFollower(Service& service, Keeper keeper)
    : service_(service),
      requester_(DrawIdentity()),
      replica_(requester_, {std::move(keeper.begin),
                            [this, apply = std::move(keeper.apply)](std::span<const TileChange> changes) {
                              if (!apply(changes)) CountRefused();
                            },
                            std::move(keeper.add)}) {
  service_.bus().Subscribe<map_delta_t>(kMapDeltaChannel, [this](const map_delta_t& delta) {
    replica_.Handle(delta);
    if (delta.recipient == requester_) next_request_ = Clock::now();  // the next page at once
  });
}

void MapFollower::CountRefused() {
  constexpr const char* kCounter = "tiles_refused";
  if (service_.counters().counts().count(kCounter) == 0) {
    Say(service_.name() + ": a MAP_DELTA has tiles that are malformed or more than a map may have; they are left out");
  }
  service_.counters().Add(kCounter);
}

void MapFollower::Poll() {
  constexpr auto kPatience = std::chrono::milliseconds(50);
  const auto request = replica_.NextRequest();
  if (!request || Clock::now() < next_request_) return;
  next_request_ = Clock::now() + kPatience;
  service_.counters().Add("map_requests");
  service_.bus().Publish(kMapRequestChannel, *request);
}

}  // namespace crsm
