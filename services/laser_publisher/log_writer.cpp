#include "services/laser_publisher/log_writer.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <stdexcept>

#include "services/base/progress.hpp"
#include "services/base/usage_error.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/event_log_writer.hpp"

namespace crsm {
namespace {

std::string PathOf(const std::string& url) {
  const std::string scheme = "file://";
  const std::string mode = "?mode=w";
  if (url.size() <= scheme.size() + mode.size() || url.substr(url.size() - mode.size()) != mode) {
    throw UsageError(fmt::format("--lcm-url {}: names no log to write; use file://PATH?mode=w", url));
  }
  return url.substr(scheme.size(), url.size() - scheme.size() - mode.size());
}

}  // namespace

void WriteLog(LaserSource& source, const std::string& source_name, const std::string& url,
              const std::string& channel_prefix, bool with_odometry) {
  const std::string path = PathOf(url);
  for (const std::string& file : FilesOfSource(source_name)) {
    std::error_code not_there;
    if (!std::filesystem::equivalent(path, file, not_there)) continue;
    throw UsageError(fmt::format("--lcm-url {}: would overwrite {}, which is read; choose another file", url, file));
  }
  CatchSignals();
  EventLogWriter log(path);
  Progress progress("laser_publisher");
  std::int64_t num_scans = 0;
  bool has_odometry = false;  // so far
  while (const auto scan = source.Next()) {
    if (StopRequested()) break;
    has_odometry |= with_odometry && source.Odometry();
    if (has_odometry) {
      log.Write(channel_prefix + kOdometryChannel, ToMessage(Odometry{scan->utime, source.Odometry()}));
    }
    AsLaserMessage(*scan, [&](const auto& message) { log.Write(channel_prefix + kLaserChannel, message); });
    if (const auto T_map_laser = source.TruePose())
      log.Write(channel_prefix + kTruePoseChannel, ToPoseMessage(scan->utime, *T_map_laser));
    progress.Show([&] { return source.Progress(); }, ++num_scans);
  }
  log.Flush();
  progress.Finish(num_scans);
}

}  // namespace crsm
