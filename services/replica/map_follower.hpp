#pragma once

#include "services/base/backoff.hpp"
#include "services/base/stall_watch.hpp"
#include "services/bus/service.hpp"
#include "services/replica/map_replica.hpp"

namespace crsm {

/// A MapReplica on the bus: asks for what is missing, the next page at once when one has come, and more and more seldom
/// while none comes.
class MapFollower {
 public:
  /// Who keeps the map; as MapReplica::Keeper, but for `apply`: false if some of the changes are malformed, or if the
  /// map has no room for them.
  struct Keeper {
    std::function<void(double cell_size_m)> begin;
    std::function<bool(std::span<const TileChange>)> apply;
    std::function<void(const ScanMatch&)> add = {};
  };

  using View = MapReplica::View;

  MapFollower(Service& service, View view, Keeper keeper);

  const MapReplica& replica() const { return replica_; }
  MapReplica& replica() { return replica_; }
  /// There may be a newer version: Poll asks for it.
  void RequestUpdate() { replica_.RequestUpdate(); }
  void AwaitSettled() { replica_.AwaitSettled(); }
  void AwaitNoLonger() { replica_.AwaitNoLonger(); }
  void TurnTo(int piece) { replica_.TurnTo(piece); }

  /// Sends the request that is due, if any; to be called often.
  void Poll();

 private:
  void Handle(const map_page_t& page);
  void CountRefused();

  Service& service_;
  MapReplica replica_;
  std::int64_t last_question_ = 0;
  Backoff backoff_{std::chrono::milliseconds(50)};
  StallWatch stall_watch_;
};

}  // namespace crsm
