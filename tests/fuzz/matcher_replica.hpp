#pragma once

#include <cstdlib>
#include <optional>

#include "common/match/rrhc_matcher.hpp"
#include "common/match/sweep.hpp"
#include "services/replica/delta_reader.hpp"
#include "services/wire/conversions.hpp"
#include "wire_messages.hpp"

namespace crsm {

/// A page comes as of an owner that answers what it was asked: no fuzzer finds the question by itself.
inline void HandleAsAsked(map_page_t page, MapReplica& replica) {
  if (const auto question = replica.NextRequest()) page.request = *question;
  replica.Handle(page);
}

/// A matcher and its replica of the map, fed as rrhc_matcher feeds them.
class MatcherReplica {
 public:
  explicit MatcherReplica(const MatchParameters& parameters, const MatchConstants& constants = {})
      : parameters_(parameters),
        constants_(constants),
        replica_(77, {[this](double cell_size_m) { matcher_.emplace(parameters_, cell_size_m, constants_); },
                      [this](std::span<const TileChange> changes) { matcher_->Apply(changes); }},
                 MapReplica::View::kMatched) {}

  bool has_map() const { return matcher_.has_value(); }
  const TrackingState& tracking() const { return replica_.tracking(); }

  /// A delta or a page. A delta comes as of the last match that was sent.
  void Handle(std::span<const std::uint8_t> bytes) {
    if (auto delta = Decode<map_delta_t>(bytes)) {
      deltas_.Await(ScanMatch{.utime = delta->utime});
      deltas_.Handle(*delta);
    }
    if (auto page = Decode<map_page_t>(bytes)) HandleAsAsked(std::move(*page), replica_);
  }

  /// The answer must be one that map_updater believes.
  void Match(const critical_rays_t& message, const TrackingState& tracking) const {
    const ScanMatch match = MatchSweep(*matcher_, FromMessage(message), tracking, {});
    if (!Decode<scan_match_t>(Encode(ToMessage(match)))) std::abort();
  }

 private:
  MatchParameters parameters_;
  MatchConstants constants_;
  std::optional<RrhcMatcher> matcher_;
  MapReplica replica_;
  DeltaReader deltas_{replica_};
};

}  // namespace crsm
