#pragma once

#include "services/runtime/map_replica.hpp"
#include "services/runtime/service.hpp"

namespace crsm {

/// A MapReplica on the bus: listens to MAP_DELTA and asks for what is missing.
class MapFollower {
 public:
  /// Takes over changed tiles. False if some of them are malformed, or if the map has no room for them.
  using ApplyChanges = std::function<bool(std::span<const TileChange>)>;

  MapFollower(Service& service, ApplyChanges apply, MapReplica::Clear clear);

  const MapReplica& replica() const { return replica_; }
  void Doubt() { replica_.Doubt(); }

  /// Sends the request that is due, if any; to be called often.
  void Poll();

 private:
  void CountRefused();

  Service& service_;
  std::int64_t requester_;
  MapReplica replica_;
  Clock::time_point next_request_{};
};

}  // namespace crsm
