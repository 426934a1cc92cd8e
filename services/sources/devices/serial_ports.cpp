#include "services/sources/devices/serial_ports.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

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

}  // namespace crsm
