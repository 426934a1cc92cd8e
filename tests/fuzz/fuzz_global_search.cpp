// MAP_DELTA and CRITICAL_RAYS, as rrhc_matcher takes them on a finished map: the scan is looked for on all of it.

#include <cstdlib>

#include "common/rrhc_matcher.hpp"
#include "input.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/map_replica.hpp"
#include "wire_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  RrhcMatcher matcher{MatchParameters{}};
  MapReplica replica(
      77, [&](std::span<const TileChange> changes) { matcher.ApplyChanges(changes); },
      [&] { matcher = RrhcMatcher(MatchParameters{}); });
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) {
    if (const auto delta = Decode<map_delta_t>(*bytes)) replica.Handle(*delta);
    const auto message = Decode<critical_rays_t>(*bytes);
    if (!message || replica.cell_size_m() == 0.0) continue;
    const CriticalRays scan = FromMessage(*message);
    const ScanMatch match =
        matcher.Match(scan.utime, scan.rays, scan.critical, {}, MapGeometry(replica.cell_size_m()), replica.version());
    if (!Decode<scan_match_t>(Encode(ToMessage(match)))) std::abort();
    break;  // it takes a second with the sanitizers, more of them would teach no more
  }
  return 0;
}
