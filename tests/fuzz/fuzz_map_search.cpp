// MAP_DELTA, MAP_PAGE and CRITICAL_RAYS, as rrhc_matcher takes them on a finished map: the scan is looked for on all of
// it.

#include "input.hpp"
#include "matcher_replica.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  MatcherReplica matcher{MatchParameters{}};
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) {
    matcher.Handle(*bytes);
    const auto scan = Decode<critical_rays_t>(*bytes);
    if (!scan || !matcher.has_map()) continue;
    matcher.Match(*scan, TrackingState::OnFinishedMap());
    break;  // it takes a second with the sanitizers, more of them would teach no more
  }
  return 0;
}
