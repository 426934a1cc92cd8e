#pragma once

#include <sys/types.h>

#include <string>

namespace crsm {

/// "process 4711 (map_updater --journal out/run)": as much of it as this process may see.
std::string DescribeProcess(pid_t pid);

}  // namespace crsm
