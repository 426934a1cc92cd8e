#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "services/sources/devices/laser_device.hpp"

namespace crsm {

/// The ports of USB lasers: ttyACM* and ttyUSB* in a folder, then serial/by-id/*, whose names stay the same. Sorted.
std::vector<std::string> FindSerialPorts(const std::filesystem::path& dev = "/dev");

/// "there are /dev/ttyACM0, /dev/ttyUSB0", or what may be the cause that there is none.
std::string DescribeSerialPorts(const std::vector<std::string>& ports);

/// What to give in place of "rplidar" or "rplidar:" alone. ports: the serial ports of this host.
std::string DescribeMissingPort(const DeviceKind& kind, const std::vector<std::string>& ports);

/// What to give in place of "rplidar:WHERE", where WHERE is neither a path nor an address. Ends with what was probably
/// meant. ports: the serial ports of this host.
std::string DescribeWrongPort(const DeviceKind& kind, std::string_view where, const std::vector<std::string>& ports);

}  // namespace crsm
