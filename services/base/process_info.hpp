#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

namespace crsm {

/// "process 4711 (map_updater --journal out/run)": as much of it as this process may see.
std::string DescribeProcess(pid_t pid);

/// Whether a process has a UDP socket at a port (IPv4). Nothing where this process may not see the other one's files.
std::optional<bool> HasUdpPort(pid_t pid, std::uint16_t port);

/// Whose the UDP sockets at a port are (IPv4). Nothing where there is none, or where they are of several users.
std::optional<uid_t> FindUdpUser(std::uint16_t port);

}  // namespace crsm
