#pragma once

#include "services/runtime/map_replica.hpp"
#include "services/runtime/service.hpp"

namespace crsm {

/// A MapReplica on the bus: listens to MAP_DELTA and asks for what is missing.
class MapFollower {
 public:
  /// Who keeps the map; as MapReplica::Keeper, but for `apply`: false if some of the changes are malformed, or if the
  /// map has no room for them.
  struct Keeper {
    std::function<void(double cell_size_m)> begin;
    std::function<bool(std::span<const TileChange>)> apply;
    std::function<void(const ScanMatch&)> add = {};
  };

  MapFollower(Service& service, Keeper keeper);

  const MapReplica& replica() const { return replica_; }
  void Doubt() { replica_.Doubt(); }
  void AskAbout(std::int64_t utime) { replica_.AskAbout(utime); }
  void ForgetAnswer() { replica_.ForgetAnswer(); }

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
