#include "services/sources/lcm_log_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "services/runtime/bus.hpp"
#include "services/runtime/conversions.hpp"
#include "services/runtime/message_types.hpp"
#include "services/sources/laser_types.hpp"

namespace crsm {
namespace {

bool IsLaser(std::string_view data) { return FindLaserType(Bytes(data)) != nullptr; }

std::optional<LaserScan> DecodeLaser(std::string_view data) {
  const LaserType* type = FindLaserType(Bytes(data));
  return type ? type->decode(Bytes(data)) : std::nullopt;
}

/// "ENCODERS (12), LASER (3, laser)", at most 20 channels.
std::string ListChannels(const std::map<std::string, std::int64_t>& num_events,
                         const std::map<std::string, std::int64_t>& num_lasers) {
  constexpr std::size_t kMaxListed = 20;
  std::vector<std::string> entries;
  for (const auto& [channel, count] : num_events) {
    if (entries.size() == kMaxListed) {
      entries.push_back(fmt::format("and {} more", num_events.size() - kMaxListed));
      break;
    }
    std::string name = channel;
    std::replace_if(
        name.begin(), name.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    entries.push_back(fmt::format("{} ({}{})", name, count, num_lasers.count(channel) ? ", laser" : ""));
  }
  return entries.empty() ? "none" : fmt::format("{}", fmt::join(entries, ", "));
}

/// The channel to take: `channel` if it has a laser's message, or the first that has one if `channel` is empty.
std::string FindLaserChannel(const std::string& path, const std::string& channel) {
  LcmEventLog log(path);
  std::map<std::string, std::int64_t> num_events;
  std::map<std::string, std::int64_t> num_lasers;
  constexpr std::size_t kMaxChannels = 1000;  // a hostile log may have a name for each event
  while (const auto event = log.Next()) {
    const bool is_laser = IsLaser(event->data);
    if (is_laser && (channel.empty() || channel == event->channel)) return event->channel;
    if (num_events.size() >= kMaxChannels && !num_events.count(event->channel)) continue;
    ++num_events[event->channel];
    if (is_laser) ++num_lasers[event->channel];
  }
  const std::string wanted = channel.empty() ? "" : fmt::format(" on channel {}", channel);
  throw std::runtime_error(fmt::format("{} has no laser messages ({}){}; its channels: {}", path, LaserTypeNames(),
                                       wanted, ListChannels(num_events, num_lasers)));
}

/// "robot1/ODOMETRY" for "robot1/LASER".
std::string OdometryChannel(const std::string& laser_channel) {
  const std::string_view laser = kLaserChannel;
  const bool is_ours = laser_channel.ends_with(laser);
  return (is_ours ? laser_channel.substr(0, laser_channel.size() - laser.size()) : "") + kOdometryChannel;
}

}  // namespace

LcmLogSource::LcmLogSource(const std::string& path, const std::string& channel)
    : log_(path), channel_(FindLaserChannel(path, channel)), odometry_channel_(OdometryChannel(channel_)) {}

std::optional<LaserScan> LcmLogSource::Next() {
  while (!NextIsReady() && ReadEvent()) {
  }
  if (waiting_.empty()) return std::nullopt;
  LaserScan scan = std::move(waiting_.front());
  waiting_.pop_front();
  T_odom_robot_ = odometry_.Find(scan.utime).T_odom_robot;
  return scan;
}

bool LcmLogSource::NextIsReady() const {
  constexpr std::size_t kMostWaiting = 8;
  if (waiting_.empty()) return false;
  const std::int64_t utime = waiting_.front().utime;
  return waiting_.size() > kMostWaiting || waiting_.back().utime - utime > OdometryBuffer::kFurthest_us ||
         odometry_.Find(utime).state != ScanOdometry::State::kAwaited;
}

bool LcmLogSource::ReadEvent() {
  const auto event = log_.Next();
  if (!event) return false;
  if (event->channel == odometry_channel_ && Is<bot_core::pose_t>(Bytes(event->data))) {
    TakeOdometry(event->data);
  } else if (event->channel == channel_) {
    TakeScan(event->data);
  } else if (IsLaser(event->data)) {
    ++counts_["other_channel"];
  }
  return true;
}

void LcmLogSource::TakeOdometry(std::string_view data) {
  if (const auto message = Decode<bot_core::pose_t>(Bytes(data))) {
    odometry_.Add(FromMessage(*message));
  } else {
    ++counts_["bad_odometry"];
  }
}

void LcmLogSource::TakeScan(std::string_view data) {
  std::optional<LaserScan> scan = DecodeLaser(data);
  if (!scan) {
    ++counts_["bad_message"];
    if (first_refusal_.empty() && Is<bot_core::planar_lidar_t>(Bytes(data))) {
      first_refusal_ = DescribeRefusedLaser(Bytes(data));
    }
  } else if (utimes_.Find(scan->utime)) {
    ++counts_["utime_repeated"];
  } else {
    utimes_.Add(scan->utime);
    ++num_scans_;
    waiting_.push_back(std::move(*scan));
  }
}

std::vector<std::string> LcmLogSource::Complaints() const {
  std::vector<std::string> complaints;
  const auto CountOf = [this](const char* name) {
    const auto count = counts_.find(name);
    return count == counts_.end() ? 0 : count->second;
  };
  if (!first_refusal_.empty() && CountOf("bad_message") > num_scans_) {
    complaints.push_back(fmt::format("{} of {} scans on {} are left out: {}", CountOf("bad_message"),
                                     CountOf("bad_message") + num_scans_, channel_, first_refusal_));
  }
  if (CountOf("utime_repeated") > num_scans_) {
    complaints.push_back(fmt::format(
        "{} of {} scans on {} have the utime of an earlier one and are left out: the driver must set utime to the "
        "moment of each scan [us]",
        CountOf("utime_repeated"), CountOf("utime_repeated") + num_scans_, channel_));
  }
  return complaints;
}

std::map<std::string, std::int64_t> LcmLogSource::Counts() const {
  std::map<std::string, std::int64_t> counts = counts_;
  counts["bad_event"] = log_.num_bad_events();
  counts["truncated"] = log_.truncated() ? 1 : 0;
  return counts;
}

}  // namespace crsm
