// MAP_DELTA and CRITICAL_RAYS, as rrhc_matcher takes them: its answer must be one that map_updater believes.

#include <cstdlib>

#include "common/rrhc_matcher.hpp"
#include "input.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/map_replica.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

MatchParameters QuickParameters() {
  MatchParameters parameters;
  parameters.num_evaluations = 30;
  parameters.wide_evaluations = 60;
  parameters.start = Pose2{};  // what looks on the whole map has a target of its own
  return parameters;
}

/// Whether the scan would be looked for on the whole map.
bool IsLostFromTheStart(const std::vector<ScanMatch>& history) {
  return !history.empty() && history.front().state == MatchState::kLost && history.back().state == MatchState::kLost;
}

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  RrhcMatcher matcher(QuickParameters());
  MapReplica replica(
      77, [&](std::span<const TileChange> changes) { matcher.ApplyChanges(changes); },
      [&] { matcher = RrhcMatcher(QuickParameters()); });
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) {
    if (const auto delta = Decode<map_delta_t>(*bytes)) replica.Handle(*delta);
    const auto message = Decode<critical_rays_t>(*bytes);
    if (!message || replica.cell_size_m() == 0.0) continue;
    const CriticalRays scan = FromMessage(*message);
    if (IsLostFromTheStart(replica.matches())) continue;
    const ScanMatch match = matcher.Match(scan.utime, scan.rays, scan.critical, replica.matches(),
                                          MapGeometry(replica.cell_size_m()), replica.version());
    if (!Decode<scan_match_t>(Encode(ToMessage(match)))) std::abort();
  }
  return 0;
}
