// MAP_DELTA, MAP_PAGE and CRITICAL_RAYS, as rrhc_matcher takes them: its answer must be one that map_updater believes.

#include "input.hpp"
#include "matcher_replica.hpp"

namespace crsm {
namespace {

MatchConstants QuickConstants() {
  MatchConstants constants;
  constants.search.num_evaluations = 30;
  constants.wide_search.num_evaluations = 60;
  return constants;
}

/// Whether the scan would be looked for on the whole map.
bool IsLostFromTheStart(const TrackingState& tracking) {
  return tracking.on_finished_map() && tracking.num_lost() == tracking.num_scans() && !tracking.empty();
}

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  MatcherReplica matcher({.start = Pose2{}}, QuickConstants());  // what looks on the whole map has a target of its own
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) {
    matcher.Handle(*bytes);
    const auto scan = Decode<critical_rays_t>(*bytes);
    if (!scan || !matcher.has_map() || IsLostFromTheStart(matcher.tracking())) continue;
    matcher.Match(*scan, matcher.tracking());
  }
  return 0;
}
