// CRITICAL_RAYS, SCAN_MATCH and MAP_REQUEST, as map_updater takes them: its answers must be ones that replicas believe.

#include <cstdlib>

#include "common/map/map_updater.hpp"
#include "input.hpp"
#include "services/map_updater/answers.cpp"  // in no library: it is map_updater's own
#include "services/runtime/conversions.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr AnswerOptions kOptions{99, 1400};

void Check(const map_delta_t& answer) {
  if (!Decode<map_delta_t>(Encode(answer))) std::abort();
}

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  MapUpdater updater({});
  MatchStore answered;
  TrackingState tracking;
  std::optional<CriticalRays> scan;
  MessageReader messages({data, size});
  while (const auto bytes = messages.Next()) {
    if (const auto rays = Decode<critical_rays_t>(*bytes)) {
      scan = FromMessage(*rays);
    } else if (const auto message = Decode<scan_match_t>(*bytes)) {
      const ScanMatch match = FromMessage(*message);
      const bool matched = scan && scan->utime == match.utime;
      const MapDelta delta = matched ? updater.Update(*scan, match) : updater.UpdateWithoutScan();
      answered.Append(match);
      tracking.Add(match);
      for (const map_delta_t& part : MakeParts(delta, match, updater.geometry(), kOptions)) Check(part);
      Check(MakeEmptyAnswer(match.utime, updater, kOptions));
    } else if (const auto request = Decode<map_request_t>(*bytes)) {
      Check(MakePage(*request, updater, {answered, tracking}, kOptions));
    }
  }
  return 0;
}
