// CARMEN and LCM logs, plain or compressed, as laser_publisher takes them. What it publishes must be believed.

#include <stdexcept>

#include "input.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"
#include "wire_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  const MemoryFile file({data, size});
  try {
    const auto source = OpenLaserSource(file.path(), {});
    while (const auto scan = source->Next()) {
      if (!Decode<bot_core::planar_lidar_t>(Encode(ToMessage(*scan)))) std::abort();
      FindValidRays(*scan, {});
    }
    source->Progress();
    source->Counts();
  } catch (const std::runtime_error&) {  // is how a log is refused
  }
  return 0;
}
