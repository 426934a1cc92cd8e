#include "services/sources/devices/serial_ports.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "common/math/nearest_name.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> FindNames(const fs::path& folder, const std::vector<std::string>& beginnings) {
  std::vector<std::string> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const auto BeginsName = [&](const std::string& beginning) { return name.starts_with(beginning); };
    if (std::ranges::any_of(beginnings, BeginsName)) paths.push_back(entry->path().string());
  }
  std::ranges::sort(paths);
  return paths;
}

/// The port or address that was probably meant; empty if there is none.
std::string FindMeant(const DeviceKind& kind, std::string_view where, const std::vector<std::string>& ports) {
  constexpr std::string_view kScheme = "tcp:";
  const std::string_view name = where.substr(0, where.find(':'));  // without the baud rate
  const bool is_path = name.find('/') != std::string_view::npos;
  const bool is_host = name.find('.') != std::string_view::npos && !is_path;
  if (where.starts_with(kScheme) || is_host || (kind.bauds.empty() && !is_path && !name.starts_with("tty"))) {
    const std::string_view host = where.substr(where.starts_with(kScheme) ? kScheme.size() : 0);
    return fmt::format("tcp://{}", host.substr(std::min(host.find_first_not_of('/'), host.size())));
  }
  if (kind.bauds.empty()) return "";
  const std::string dev = "/dev/";
  const std::string port = dev + std::string(name.substr(name.starts_with("dev/") ? 4 : 0));
  std::vector<std::string> names;
  for (const std::string& path : ports) names.push_back(path.substr(path.starts_with(dev) ? dev.size() : 0));
  const std::string nearest = FindNearestName(port.substr(dev.size()), names);
  if (nearest.empty() && !port.starts_with("/dev/tty")) return "";
  return (nearest.empty() ? port : dev + nearest) + std::string(where.substr(name.size()));
}

}  // namespace

std::vector<std::string> FindSerialPorts(const fs::path& dev) {
  std::vector<std::string> ports = FindNames(dev, {"ttyACM", "ttyUSB"});
  std::ranges::move(FindNames(dev / "serial/by-id", {""}), std::back_inserter(ports));
  return ports;
}

std::string DescribeSerialPorts(const std::vector<std::string>& ports) {
  if (ports.empty()) return "there is no port of a USB laser at all: does it have power, and is its cable plugged in?";
  return fmt::format("there are {}", fmt::join(ports, ", "));
}

std::string DescribeMissingPort(const DeviceKind& kind, const std::vector<std::string>& ports) {
  if (kind.bauds.empty()) {
    return fmt::format("{0}: the address of the laser is missing: give {0}:tcp://ADDRESS", kind.name);
  }
  return fmt::format("{0}: the port of the laser is missing: give {0}:{1}; {2}", kind.name,
                     ports.empty() ? "/dev/NAME" : ports.front(), DescribeSerialPorts(ports));
}

std::string DescribeWrongPort(const DeviceKind& kind, std::string_view where, const std::vector<std::string>& ports) {
  const std::string meant = FindMeant(kind, where, ports);
  std::string text = fmt::format("{0}:{1}: is {2}{0}:tcp://HOST:PORT", kind.name, where,
                                 kind.bauds.empty() ? "not " : fmt::format("neither {}:/dev/NAME nor ", kind.name));
  if (!meant.empty()) return text + fmt::format("; did you mean {}:{}?", kind.name, meant);
  return kind.bauds.empty() ? text : text + "; " + DescribeSerialPorts(ports);
}

}  // namespace crsm
