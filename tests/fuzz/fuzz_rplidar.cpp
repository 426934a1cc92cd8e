// What an RPLidar says, from its first answer on.

#include "device_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  crsm::FeedDevice(&crsm::MakeRplidar, {data, size});
  return 0;
}
