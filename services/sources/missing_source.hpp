#pragma once

#include <string>
#include <vector>

#include "services/sources/devices/laser_device.hpp"

namespace crsm {

/// Throws, in one line, for a source that is no file. UsageError: of "live", which run_stack alone maps, and of a kind
/// of laser without its port. Else std::runtime_error, with the file, world or laser that was probably meant.
[[noreturn]] void ThrowMissingSource(const std::string& name);

/// What to give in place of "rplidar" alone. ports: the serial ports of this host.
std::string DescribeMissingPort(const DeviceKind& kind, const std::vector<std::string>& ports);

}  // namespace crsm
