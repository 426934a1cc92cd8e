// MAP_DELTA, MAP_PAGE, CRITICAL_RAYS and START_POSE, as rrhc_matcher takes them: its answer must be one that
// map_updater believes.

#include "input.hpp"
#include "matcher_replica.hpp"
#include "services/wire/pose_types.hpp"

namespace crsm {
namespace {

MatchConstants QuickConstants() {
  MatchConstants constants;
  constants.search.num_evaluations = 30;
  constants.map_search.most_evaluations = 60;
  constants.map_search.most_whole_evaluations = 60;
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
  std::optional<Pose2> told_start;
  while (const auto bytes = messages.Next()) {
    matcher.Handle(*bytes);
    if (const auto pose = DecodePose(*bytes)) told_start = pose->T_odom_robot;
    const auto scan = Decode<critical_rays_t>(*bytes);
    if (!scan || !matcher.has_map() || IsLostFromTheStart(matcher.tracking())) continue;
    const TrackingState& tracking = matcher.tracking();
    const bool is_told = told_start && tracking.on_finished_map() && !tracking.empty();
    matcher.Match(*scan, is_told ? tracking.MovedTo(*told_start) : tracking);
    told_start.reset();
  }
  return 0;
}
