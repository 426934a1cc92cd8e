// What a laser sends, of every type, as ray_selector takes it: its answer must be one that rrhc_matcher believes. And
// what it says of the laser.

#include <cstdlib>

#include "common/diagnosis/laser_judge.hpp"
#include "common/scan/ray_selector.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/laser_types.hpp"
#include "wire_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  const auto laser = DecodeLaser({data, size}, {});
  if (!laser) return 0;
  const LaserScan& scan = laser->scan;
  LaserJudge judge{ScanParameters{}};
  LaserScan next = scan;
  for (int i = 0; i < 12; ++i) {  // enough for a verdict
    judge.Look(next);
    ++next.utime;
  }
  for (const auto algorithm : {Algorithm::kCrsm, Algorithm::kPaper}) {
    Parameters parameters;
    parameters.update.algorithm = algorithm;
    const critical_rays_t answer = ToMessage(RaySelector(parameters).Select(scan));
    if (!Decode<critical_rays_t>(Encode(answer))) std::abort();
  }
  return 0;
}
