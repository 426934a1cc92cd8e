// ROS 1 bags.

#include "bag_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  crsm::ReadBag("#ROSBAG V2.0\n", {data, size});
  return 0;
}
