#pragma once

#include <cstdlib>

#include "common/match/rrhc_matcher.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/map_replica.hpp"
#include "wire_messages.hpp"

namespace crsm {

/// A matcher and its replica of the map, fed as rrhc_matcher feeds them.
class MatcherReplica {
 public:
  explicit MatcherReplica(const MatchParameters& parameters)
      : parameters_(parameters),
        matcher_(parameters),
        replica_(
            77, [this](std::span<const TileChange> changes) { matcher_.ApplyChanges(changes); },
            [this] { matcher_ = RrhcMatcher(parameters_); }) {}

  bool has_map() const { return replica_.cell_size_m() > 0.0; }
  std::span<const ScanMatch> history() const { return replica_.matches(); }

  void Handle(const map_delta_t& delta) { replica_.Handle(delta); }

  /// The answer must be one that map_updater believes.
  void Match(const critical_rays_t& message, std::span<const ScanMatch> history) const {
    const CriticalRays scan = FromMessage(message);
    const ScanMatch match = matcher_.Match(scan.utime, scan.rays, scan.critical, history,
                                           MapGeometry(replica_.cell_size_m()), replica_.version());
    if (!Decode<scan_match_t>(Encode(ToMessage(match)))) std::abort();
  }

 private:
  MatchParameters parameters_;
  RrhcMatcher matcher_;
  MapReplica replica_;
};

}  // namespace crsm
