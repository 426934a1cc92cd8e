#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace crsm {

/// The ports of USB lasers: ttyACM* and ttyUSB* in a folder, then serial/by-id/*, whose names stay the same. Sorted.
std::vector<std::string> FindSerialPorts(const std::filesystem::path& dev = "/dev");

/// "there are /dev/ttyACM0, /dev/ttyUSB0", or what may be the cause that there is none.
std::string DescribeSerialPorts(const std::vector<std::string>& ports);

}  // namespace crsm
