// MCAP files.

#include "bag_file.hpp"
#include "services/sources/bags/mcap_format.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  crsm::ReadBag(crsm::kMcapMagic, {data, size});
  return 0;
}
