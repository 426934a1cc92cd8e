// MAP_DELTA and CRITICAL_RAYS, as rrhc_matcher takes them: its answer must be one that map_updater believes.

#include "input.hpp"
#include "matcher_replica.hpp"

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
bool IsLostFromTheStart(const TrackingState& tracking) {
  return tracking.on_finished_map() && tracking.num_lost() == tracking.num_scans() && !tracking.empty();
}

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  MatcherReplica matcher(QuickParameters());
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) {
    if (const auto delta = Decode<map_delta_t>(*bytes)) matcher.Handle(*delta);
    const auto scan = Decode<critical_rays_t>(*bytes);
    if (!scan || !matcher.has_map() || IsLostFromTheStart(matcher.tracking())) continue;
    matcher.Match(*scan, matcher.tracking());
  }
  return 0;
}
