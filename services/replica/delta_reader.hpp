#pragma once

#include <cstdint>
#include <map>

#include "services/base/held_by_utime.hpp"
#include "services/replica/map_replica.hpp"

namespace crsm {

/// Leads a matcher's replica of the map from one version to the next, as the owner answers its matches (MAP_DELTA).
/// When a version is missed, or was made by a match that is not known here, such as that of a matcher before this one,
/// the replica doubts and asks for pages.
class DeltaReader {
 public:
  explicit DeltaReader(MapReplica& replica) : replica_(replica) {}

  /// A match has been sent: its delta leads on from it.
  void Await(const ScanMatch& match) { awaited_.Hold(match); }

  void Handle(const map_delta_t& part);

 private:
  void Apply();

  static constexpr std::size_t kMostAwaited = 64;  ///< far more than a matcher goes on without an answer
  MapReplica& replica_;
  HeldByUtime<ScanMatch, kMostAwaited> awaited_;
  std::map<std::int32_t, map_delta_t> parts_;  ///< of one version, by number; together no larger than a map
};

}  // namespace crsm
