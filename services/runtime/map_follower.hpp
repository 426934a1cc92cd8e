#pragma once

#include "services/runtime/backoff.hpp"
#include "services/runtime/map_replica.hpp"
#include "services/runtime/service.hpp"
#include "services/runtime/stall_watch.hpp"

namespace crsm {

/// A MapReplica on the bus: listens to MAP_DELTA and asks for what is missing, the next page at once when one has come,
/// and more and more seldom while none comes.
class MapFollower {
 public:
  /// Who keeps the map; as MapReplica::Keeper, but for `apply`: false if some of the changes are malformed, or if the
  /// map has no room for them.
  struct Keeper {
    std::function<void(double cell_size_m)> begin;
    std::function<bool(std::span<const TileChange>)> apply;
    std::function<void(const ScanMatch&)> add = {};
  };

  /// Which map of the owner's.
  enum class View {
    kMatched,  ///< that scans are matched to: told of every change
    kWhole     ///< all that was seen, where it belongs by all that is known: as of the last time it was asked for
  };

  MapFollower(Service& service, View view, Keeper keeper);

  const MapReplica& replica() const { return replica_; }
  void Doubt() { replica_.Doubt(); }
  /// Doubts; and from now on the owner answers when loops have been looked for in all scans so far.
  void AwaitSettled();
  void AskAbout(std::int64_t utime) { replica_.AskAbout(utime); }
  void ForgetAnswer() { replica_.ForgetAnswer(); }

  /// Sends the request that is due, if any; to be called often.
  void Poll();

 private:
  void CountRefused();

  Service& service_;
  View view_;
  bool settled_ = false;
  MapReplica replica_;
  std::optional<map_request_t> last_request_;
  Backoff backoff_{std::chrono::milliseconds(50)};
  StallWatch stall_watch_;
};

}  // namespace crsm
