// World files: driven through for a few scans, or refused in words.

#include <stdexcept>

#include "common/worlds/simulator.hpp"
#include "input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  try {
    Simulator simulator(ParseWorld(std::string(reinterpret_cast<const char*>(data), size), "fuzz"), 1);
    for (int i = 0; i < 3 && simulator.Next(); ++i) simulator.Progress();
  } catch (const std::runtime_error&) {  // is how a world is refused
  }
  return 0;
}
