#include "services/laser_publisher/log_writer.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <vector>

#include "services/runtime/conversions.hpp"
#include "services/runtime/bus.hpp"
#include "services/runtime/progress.hpp"

namespace crsm {
namespace {

std::string PathOf(const std::string& url) {
  const std::string scheme = "file://";
  const std::string mode = "?mode=w";
  if (url.size() <= scheme.size() + mode.size() || url.substr(url.size() - mode.size()) != mode) {
    throw std::runtime_error(fmt::format("--lcm-url {}: to write a log say file://PATH?mode=w", url));
  }
  return url.substr(scheme.size(), url.size() - scheme.size() - mode.size());
}

}  // namespace

void WriteLog(LaserSource& source, const std::string& url, const std::string& channel_prefix) {
  const std::string path = PathOf(url);
  lcm::LogFile log(path, "w");
  if (!log.good()) throw std::runtime_error(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));

  Progress progress("laser_publisher");
  std::int64_t num_scans = 0;
  std::int64_t last_utime = 0;
  std::vector<std::uint8_t> bytes;
  while (const auto scan = source.Next()) {
    if (StopRequested()) break;
    const bot_core::planar_lidar_t message = ToMessage(*scan);
    bytes.resize(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    last_utime = std::max(last_utime, scan->utime);
    lcm::LogEvent event{num_scans++, last_utime, channel_prefix + kLaserChannel, static_cast<std::int32_t>(bytes.size()),
                        bytes.data()};
    if (log.writeEvent(&event) != 0) {
      throw std::runtime_error(fmt::format("{}: cannot be written on: {}", path, std::strerror(errno)));
    }
    progress.Show(source.Progress(), num_scans);
  }
  if (std::fflush(log.getFilePtr()) != 0) {
    throw std::runtime_error(fmt::format("{}: cannot be written on: {}", path, std::strerror(errno)));
  }
  progress.Finish(num_scans);
}

}  // namespace crsm
