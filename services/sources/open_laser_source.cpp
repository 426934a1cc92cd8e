#include "services/sources/open_laser_source.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>

#include "common/logs/carmen_log.hpp"
#include "common/logs/gzip_file.hpp"
#include "common/logs/left_out.hpp"
#include "common/worlds/simulator.hpp"
#include "services/base/file_window.hpp"
#include "services/base/printable.hpp"
#include "services/base/process.hpp"
#include "services/sources/bags/bag_folder.hpp"
#include "services/sources/bags/bag_source.hpp"
#include "services/sources/devices/live_laser.hpp"
#include "services/sources/lcm_log_source.hpp"
#include "services/sources/missing_source.hpp"
#include "services/sources/parts_source.hpp"
#include "services/sources/unpacked_file.hpp"
#include "services/sources/unpacker.hpp"
#include "services/wire/lcm_event_log.hpp"

namespace crsm {
namespace {

constexpr std::string_view kSimulated = "sim:";
constexpr const char* kLog = "a CARMEN or LCM log, or a bag";

void CheckNoTopic(const SourceOptions& options, const std::string& why) {
  if (options.odometry_topic.empty()) return;
  throw std::runtime_error(fmt::format("--odometry-topic {}: {}; remove it", options.odometry_topic, why));
}

void CheckNoFrame(const SourceOptions& options, const std::string& why) {
  if (options.laser.frame.empty()) return;
  throw std::runtime_error(fmt::format("--laser-frame {}: {}; remove it", options.laser.frame, why));
}

/// Who is asked to end finds nothing any more: that is not the log's fault.
void ThrowIfStopped(const std::string& name) {
  if (StopRequested()) throw std::runtime_error(fmt::format("{}: stopped before its first scan was found", name));
}

/// Another source, but for what a child class changes.
class SourceAround : public LaserSource {
 public:
  explicit SourceAround(std::unique_ptr<LaserSource> source) : source_(std::move(source)) {}

  std::optional<LaserScan> Next() override { return source_->Next(); }
  bool IsLive() const override { return source_->IsLive(); }
  std::optional<LaserScan> Poll(std::chrono::milliseconds longest) override { return source_->Poll(longest); }
  std::string Channel() const override { return source_->Channel(); }
  std::optional<Pose2> TruePose() const override { return source_->TruePose(); }
  std::optional<Pose2> Odometry() const override { return source_->Odometry(); }
  std::string OdometryName() const override { return source_->OdometryName(); }
  bool IsUpsideDown() const override { return source_->IsUpsideDown(); }
  double Progress() const override { return source_->Progress(); }
  std::map<std::string, std::int64_t> Counts() const override { return source_->Counts(); }
  std::vector<std::string> Complaints() const override { return source_->Complaints(); }
  std::vector<std::string> OdometryNotes() const override { return source_->OdometryNotes(); }

 private:
  std::unique_ptr<LaserSource> source_;
};

/// A log whose compressed file is cut short or damaged.
class CutSource : public SourceAround {
 public:
  using SourceAround::SourceAround;

  std::map<std::string, std::int64_t> Counts() const override {
    std::map<std::string, std::int64_t> counts = SourceAround::Counts();
    counts["truncated"] = 1;
    return counts;
  }
};

/// One whose scans are mirror images, and are turned round.
class MirroredSource : public SourceAround {
 public:
  using SourceAround::SourceAround;

  std::optional<LaserScan> Next() override { return TurnRound(SourceAround::Next()); }
  std::optional<LaserScan> Poll(std::chrono::milliseconds longest) override {
    return TurnRound(SourceAround::Poll(longest));
  }

 private:
  static std::optional<LaserScan> TurnRound(std::optional<LaserScan> scan) {
    return scan ? std::optional(Mirror(*std::move(scan))) : std::nullopt;
  }
};

template <class Source, class... Arguments>
std::unique_ptr<LaserSource> Make(const SourceOptions& options, Arguments&&... arguments) {
  auto source = std::make_unique<Source>(std::forward<Arguments>(arguments)...);
  if (!options.messages.mirrored) return source;
  return std::make_unique<MirroredSource>(std::move(source));
}

std::unique_ptr<LaserSource> OpenPlainLog(const std::string& name, const std::string& path,
                                          const SourceOptions& options) {
  constexpr std::size_t kSearchedBytes = std::size_t{1} << 16;
  constexpr int kSearchedLines = 10000;
  GzipFile file(path);
  const std::string_view start = file.Peek(kSearchedBytes).substr(0, kSearchedBytes);
  if (start.empty()) {
    throw std::runtime_error(
        fmt::format("{} is {}, must be {}", name, file.truncated() ? "a damaged gzip file" : "empty", kLog));
  }
  if (IsBag(start)) {
    return Make<BagSource>(options, name, options.laser, options.odometry_topic, options.messages.scan);
  }
  if (HasLcmSync(start)) {
    return std::make_unique<LcmLogSource>(path, options.laser, options.messages, options.odometry_topic);
  }
  if (HasCarmenLaser(file, kSearchedLines)) {
    CheckNoFrame(options, name + " is a CARMEN log, whose scans name no frame");
    CheckNoTopic(options, name + " is a CARMEN log, which has its odometry in the lines of the laser");
    return Make<CarmenLog>(options, path);
  }
  throw std::runtime_error(
      fmt::format("{} is neither a CARMEN log (no FLASER or ROBOTLASER1 line in its first {} lines) nor an LCM log, "
                  "nor a bag of ROS or MCAP",
                  name, kSearchedLines));
}

/// What gzip has compressed is read as it is; what others have, is unpacked first.
std::unique_ptr<LaserSource> OpenLog(const std::string& name, const SourceOptions& options) {
  constexpr std::size_t kStartBytes = 16;
  const std::string compression = FindCompression(FileWindow(name).At(0, kStartBytes));
  const bool is_read_as_it_is = compression.empty() || compression == "gzip";
  try {
    if (is_read_as_it_is) return OpenPlainLog(name, name, options);
    auto source = OpenPlainLog(name, PathOfUnpacked(name, Say), options);
    return IsUnpackedWhole(name) ? std::move(source) : std::make_unique<CutSource>(std::move(source));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(NameUnpacked(error.what()));
  }
}

}  // namespace

SourceOptions SourceOptionsOf(const CommandLine& command_line) {
  const Parameters& parameters = command_line.parameters();
  const Settings& settings = command_line.settings();
  return {parameters.match.seed,
          {settings.laser_channel, settings.laser_frame},
          LaserMessagesOf(command_line),
          command_line.program(),
          settings.odometry ? settings.odometry_topic : ""};
}

std::string DescribeSources() {
  return "CARMEN or LCM log; bag of ROS 1 or 2, or MCAP; these also compressed;\n'NAME.*', the parts of a log;\n"
         "sim:FILE, or sim:NAME of " +
         DescribeBuiltInWorlds() + ";\n" + DescribeDevices();
}

std::unique_ptr<LaserSource> OpenLaserSource(const std::string& name, const SourceOptions& options) {
  if (name.starts_with(kSimulated)) {
    CheckNoFrame(options, "a simulated world has one laser");
    CheckNoTopic(options, "a simulated world has its odometry in its line 'wheels'");
    return Make<Simulator>(options, LoadWorld(name.substr(kSimulated.size())), options.seed);
  }
  if (const auto device = ParseDevice(name)) {
    CheckNoFrame(options, "a laser names no frame");
    CheckNoTopic(options, "a laser has no odometry");
    return Make<LiveLaser>(
        options, *device,
        [prefix = fmt::format("{}: {}: ", options.program, name)](const std::string& line) { Say(prefix + line); });
  }

  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(name, error);
  if (!std::filesystem::exists(status)) {
    if (!IsPattern(name)) ThrowMissingSource(name);
    return std::make_unique<PartsSource>(FindParts(name),
                                         [options](const std::string& part, const std::string& channel) {
                                           SourceOptions of_part = options;
                                           if (of_part.laser.channel.empty()) of_part.laser.channel = channel;
                                           return OpenLaserSource(part, of_part);
                                         });
  }
  if (std::filesystem::is_directory(status)) {
    if (IsBagFolder(name)) {
      return Make<BagSource>(options, name, options.laser, options.odometry_topic, options.messages.scan);
    }
    throw std::runtime_error(fmt::format("{} is a directory without a bag of ROS 2, must be {}", name, kLog));
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw std::runtime_error(fmt::format("{} is no regular file, must be {}", name, kLog));
  }
  try {
    return OpenLog(name, options);
  } catch (const std::runtime_error&) {
    ThrowIfStopped(name);
    throw;
  }
}

std::vector<std::string> FilesOfSource(const std::string& name) {
  const std::string path = name.starts_with(kSimulated) ? name.substr(kSimulated.size()) : name;
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    std::vector<std::string> files;
    for (std::filesystem::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
      files.push_back(entry->path().string());
    }
    return files;
  }
  if (std::filesystem::exists(path, error)) return {path};
  return IsPattern(path) ? FindParts(path) : std::vector<std::string>();
}

void ThrowNoScans(const std::string& name, const LaserSource& source) {
  ThrowIfStopped(name);
  const std::vector<std::string> complaints = source.Complaints();
  throw std::runtime_error(
      fmt::format("{} has no scans{}", name, complaints.empty() ? "" : ": " + MakePrintable(complaints.front())));
}

std::string DescribeCut(const std::string& name, const LaserSource& source) {
  if (FindCount(source.Counts(), "truncated") == 0) return "";
  std::error_code error;
  if (IsPattern(name) && !std::filesystem::exists(name, error))
    return fmt::format("{}: a part is cut short or damaged: scans that it had are missing (truncated)", name);
  return fmt::format("{} is cut short or damaged at its end: only the scans before that were read (truncated)", name);
}

std::vector<std::string> DescribeComplaints(const std::string& name, const LaserSource& source) {
  std::vector<std::string> lines;
  for (const std::string& complaint : source.Complaints()) {
    lines.push_back(fmt::format("{}: {}", name, MakePrintable(complaint)));
  }
  return lines;
}

std::vector<std::string> DescribeOdometry(const std::string& name, const LaserSource& source) {
  std::vector<std::string> lines;
  for (const std::string& note : source.OdometryNotes())
    lines.push_back(fmt::format("{} {}", name, MakePrintable(note)));
  return lines;
}

}  // namespace crsm
