#pragma once

#include <cstdlib>
#include <optional>

#include "common/match/rrhc_matcher.hpp"
#include "common/match/sweep.hpp"
#include "services/replica/map_replica.hpp"
#include "services/wire/conversions.hpp"
#include "wire_messages.hpp"

namespace crsm {

/// A matcher and its replica of the map, fed as rrhc_matcher feeds them.
class MatcherReplica {
 public:
  explicit MatcherReplica(const MatchParameters& parameters)
      : parameters_(parameters),
        replica_(77, {[this](double cell_size_m) { matcher_.emplace(parameters_, cell_size_m); },
                      [this](std::span<const TileChange> changes) { matcher_->Apply(changes); }}) {}

  bool has_map() const { return matcher_.has_value(); }
  const TrackingState& tracking() const { return replica_.tracking(); }

  /// A page comes as of an owner that answers what it was asked: no fuzzer finds the question by itself.
  void Handle(map_delta_t delta) {
    const auto question = replica_.NextRequest();
    if (delta.num_requests == 1 && question) delta.request = {*question};
    replica_.Handle(delta);
  }

  /// The answer must be one that map_updater believes.
  void Match(const critical_rays_t& message, const TrackingState& tracking) const {
    const ScanMatch match = MatchSweep(*matcher_, FromMessage(message), tracking, {});
    if (!Decode<scan_match_t>(Encode(ToMessage(match)))) std::abort();
  }

 private:
  MatchParameters parameters_;
  std::optional<RrhcMatcher> matcher_;
  MapReplica replica_;
};

}  // namespace crsm
