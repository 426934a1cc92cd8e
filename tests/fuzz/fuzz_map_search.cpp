// MAP_DELTA, MAP_PAGE and CRITICAL_RAYS, as rrhc_matcher takes them on a finished map: the scan is looked for on all of
// it.

#include "input.hpp"
#include "matcher_replica.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  MatchConstants constants;
  constants.map_search.most_whole_evaluations = 200'000;  // more teach no more, and take long with the sanitizers
  MatcherReplica matcher(MatchParameters{}, constants);
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) {
    matcher.Handle(*bytes);
    const auto scan = Decode<critical_rays_t>(*bytes);
    if (!scan || !matcher.has_map()) continue;
    matcher.Match(*scan, TrackingState::OnFinishedMap());
    break;
  }
  return 0;
}
