#include "services/sources/open_laser_source.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>

#include "common/logs/carmen_log.hpp"
#include "common/logs/gzip_file.hpp"
#include "common/logs/left_out.hpp"
#include "common/worlds/simulator.hpp"
#include "services/base/printable.hpp"
#include "services/base/process.hpp"
#include "services/sources/bags/bag_folder.hpp"
#include "services/sources/bags/bag_source.hpp"
#include "services/sources/devices/live_laser.hpp"
#include "services/sources/lcm_log_source.hpp"
#include "services/wire/lcm_event_log.hpp"

namespace crsm {
namespace {

constexpr const char* kLog = "a CARMEN or LCM log, or a bag";

void CheckNoTopic(const SourceOptions& options, const std::string& why) {
  if (!options.odometry.is_used || options.odometry.topic.empty()) return;
  throw std::runtime_error(fmt::format("--odometry-topic {}: {}; remove it", options.odometry.topic, why));
}

void CheckNoFrame(const SourceOptions& options, const std::string& why) {
  if (options.laser.frame.empty()) return;
  throw std::runtime_error(fmt::format("--laser-frame {}: {}; remove it", options.laser.frame, why));
}

std::unique_ptr<LaserSource> OpenLog(const std::string& name, const SourceOptions& options) {
  constexpr std::size_t kSearchedBytes = std::size_t{1} << 16;
  constexpr int kSearchedLines = 10000;
  GzipFile file(name);
  const std::string_view start = file.Peek(kSearchedBytes).substr(0, kSearchedBytes);
  if (start.empty()) {
    throw std::runtime_error(
        fmt::format("{} is {}, must be {}", name, file.truncated() ? "a damaged gzip file" : "empty", kLog));
  }
  if (IsBag(start)) {
    if (file.is_compressed()) {
      throw std::runtime_error(fmt::format("{} is a gzip-compressed bag: run gunzip on it first", name));
    }
    return std::make_unique<BagSource>(name, options.laser, options.odometry, options.messages.scan);
  }
  if (HasLcmSync(start)) {
    return std::make_unique<LcmLogSource>(name, options.laser, options.messages, options.odometry);
  }
  if (HasCarmenLaser(file, kSearchedLines)) {
    CheckNoFrame(options, name + " is a CARMEN log, whose scans name no frame");
    CheckNoTopic(options, name + " is a CARMEN log, which has its odometry in the lines of the laser");
    return std::make_unique<CarmenLog>(name, options.odometry.is_used);
  }
  throw std::runtime_error(
      fmt::format("{} is neither a CARMEN log (no FLASER or ROBOTLASER1 line in its first {} lines) nor an LCM log, "
                  "nor a bag of ROS or MCAP",
                  name, kSearchedLines));
}

}  // namespace

SourceOptions SourceOptionsOf(const CommandLine& command_line) {
  const Parameters& parameters = command_line.parameters();
  const Settings& settings = command_line.settings();
  return {parameters.match.seed,
          {settings.laser_channel, settings.laser_frame},
          LaserMessagesOf(command_line),
          command_line.program(),
          {settings.odometry, settings.odometry_topic}};
}

std::string DescribeSources() {
  return "CARMEN or LCM log, also gzip-compressed; bag of ROS 1 or 2, or MCAP; sim:FILE, or sim:NAME of " +
         DescribeBuiltInWorlds() + "; " + DescribeDevices();
}

std::unique_ptr<LaserSource> OpenLaserSource(const std::string& name, const SourceOptions& options) {
  constexpr std::string_view kSimulated = "sim:";
  if (name.starts_with(kSimulated)) {
    CheckNoFrame(options, "a simulated world has one laser");
    CheckNoTopic(options, "a simulated world has its odometry in its line 'wheels'");
    return std::make_unique<Simulator>(LoadWorld(name.substr(kSimulated.size())), options.seed);
  }
  if (const auto device = ParseDevice(name)) {
    CheckNoFrame(options, "a laser names no frame");
    CheckNoTopic(options, "a laser has no odometry");
    return std::make_unique<LiveLaser>(*device, [prefix = fmt::format("{}: {}: ", options.program, name)](
                                                    const std::string& line) { Say(prefix + line); });
  }

  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(name, error);
  if (!std::filesystem::exists(status)) throw std::runtime_error(fmt::format("there is no file {}", name));
  if (std::filesystem::is_directory(status)) {
    if (IsBagFolder(name))
      return std::make_unique<BagSource>(name, options.laser, options.odometry, options.messages.scan);
    throw std::runtime_error(fmt::format("{} is a directory without a bag of ROS 2, must be {}", name, kLog));
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw std::runtime_error(fmt::format("{} is no regular file, must be {}", name, kLog));
  }
  return OpenLog(name, options);
}

void ThrowNoScans(const std::string& name, const LaserSource& source) {
  const std::vector<std::string> complaints = source.Complaints();
  throw std::runtime_error(
      fmt::format("{} has no scans{}", name, complaints.empty() ? "" : ": " + MakePrintable(complaints.front())));
}

std::string DescribeCut(const std::string& name, const LaserSource& source) {
  if (FindCount(source.Counts(), "truncated") == 0) return "";
  return fmt::format("{} is cut short or damaged at its end: only the scans before that were read (truncated)", name);
}

std::vector<std::string> DescribeOdometry(const std::string& name, const LaserSource& source) {
  std::vector<std::string> lines;
  for (const std::string& note : source.OdometryNotes())
    lines.push_back(fmt::format("{} {}", name, MakePrintable(note)));
  return lines;
}

}  // namespace crsm
