#include "services/map_updater/journal.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string_view>

#include "services/runtime/bus.hpp"
#include "services/runtime/conversions.hpp"
#include "services/sources/lcm_event_log.hpp"

namespace crsm {
namespace {

std::span<const std::uint8_t> Bytes(std::string_view data) {
  return {reinterpret_cast<const std::uint8_t*>(data.data()), data.size()};
}

std::string PathIn(const std::filesystem::path& folder) { return (folder / "journal.lcm").string(); }

}  // namespace

Journal::Journal(const std::filesystem::path& folder) {
  const std::string path = PathIn(folder);
  if (std::filesystem::exists(path)) {
    throw std::runtime_error(
        fmt::format("{} is there already: --resume goes on with it; or choose another folder", path));
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw std::runtime_error(fmt::format("--journal {}: cannot be written: {}", folder.string(), error.message()));
  }
  log_.emplace(path, EventLogWriter::Mode::kNew);
}

Journal::Journal(const std::filesystem::path& folder, const Visit& visit) {
  const std::string path = PathIn(folder);
  LcmEventLog log(path);
  std::optional<LaserScan> scan;
  std::int64_t last_utime = 0;
  while (const auto event = log.Next()) {
    if (auto laser = Decode<bot_core::planar_lidar_t>(Bytes(event->data))) {
      scan = FromMessage(*laser);
    } else if (const auto message = Decode<scan_match_t>(Bytes(event->data))) {
      const ScanMatch match = FromMessage(*message);
      visit(scan && scan->utime == match.utime ? &*scan : nullptr, match);
      last_utime = std::max(last_utime, match.utime);
    }
  }
  if (log.num_bad_events() > 0) {
    throw std::runtime_error(fmt::format("{} is damaged in {} places: its map would not be the one that was made", path,
                                         log.num_bad_events()));
  }
  num_cut_bytes_ = std::filesystem::file_size(path) - log.whole_bytes();
  if (num_cut_bytes_ > 0) std::filesystem::resize_file(path, log.whole_bytes());
  log_.emplace(path, EventLogWriter::Mode::kAppend, last_utime);
}

void Journal::Append(const LaserScan* scan, const ScanMatch& match) {
  if (scan) log_->Write(kLaserChannel, ToMessage(*scan));
  log_->Write(kScanMatchChannel, ToMessage(match));
  log_->Flush();
}

}  // namespace crsm
