#include "services/sources/lcm_log_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bot_core/planar_lidar_t.hpp>
#include <botlab/lidar_nranges_t.hpp>
#include <botlab/lidar_t.hpp>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "common/trigonometry.hpp"

namespace crsm {
namespace {

constexpr double kMaxAngle_rad = 100.0;  // no laser's geometry is beyond it
constexpr std::size_t kCountAt = 16;     // of the first array's size: after the fingerprint and the utime
constexpr std::size_t kArraysAt = 20;

std::int64_t Fingerprint(std::string_view message) {
  return message.size() < 8 ? 0 : static_cast<std::int64_t>(ReadBigEndian(message, 0, 8));
}

bool IsLaser(std::string_view message) {
  const std::int64_t fingerprint = Fingerprint(message);
  return fingerprint == bot_core::planar_lidar_t::getHash() || fingerprint == botlab::lidar_t::getHash() ||
         fingerprint == botlab::lidar_nranges_t::getHash();
}

/// Beams of a message whose arrays begin with `count` beams of `bytes_per_beam`; nothing if they cannot be there.
/// The generated decoders believe the counts, so that these are checked against the message before they run.
std::optional<std::size_t> CheckedBeams(std::string_view message, std::size_t bytes_per_beam) {
  if (message.size() < kArraysAt) return std::nullopt;
  const std::uint64_t count = ReadBigEndian(message, kCountAt, 4);
  if (count < kMinBeams || count > kMaxBeams || message.size() < kArraysAt + count * bytes_per_beam)
    return std::nullopt;
  return count;
}

bool IsAngle(double angle_rad) { return std::abs(angle_rad) <= kMaxAngle_rad; }  // not so for NaN

std::optional<LaserScan> DecodePlanarLidar(std::string_view message) {
  const auto num_beams = CheckedBeams(message, sizeof(float));
  if (!num_beams) return std::nullopt;
  const std::size_t intensities_at = kArraysAt + *num_beams * sizeof(float) + 4;
  if (message.size() < intensities_at) return std::nullopt;
  const std::uint64_t num_intensities = ReadBigEndian(message, intensities_at - 4, 4);
  if (num_intensities > kMaxBeams) return std::nullopt;
  if (message.size() != intensities_at + (num_intensities + 2) * sizeof(float)) return std::nullopt;

  bot_core::planar_lidar_t lidar;
  if (lidar.decode(message.data(), 0, static_cast<int>(message.size())) < 0) return std::nullopt;
  if (!IsAngle(lidar.rad0) || !IsAngle(lidar.radstep) || lidar.radstep == 0.0f) return std::nullopt;
  return LaserScan{lidar.utime, lidar.rad0, lidar.radstep, lidar.ranges};
}

/// botlab_lidar_t: botlab::lidar_t or botlab::lidar_nranges_t.
template <class botlab_lidar_t>
std::optional<LaserScan> DecodeBotlabLidar(std::string_view message) {
  constexpr std::size_t kBytesPerBeam = 3 * sizeof(float) + sizeof(std::int64_t);
  const auto num_beams = CheckedBeams(message, kBytesPerBeam);
  if (!num_beams || message.size() != kArraysAt + *num_beams * kBytesPerBeam) return std::nullopt;
  botlab_lidar_t lidar;
  if (lidar.decode(message.data(), 0, static_cast<int>(message.size())) < 0) return std::nullopt;

  constexpr int kGridBeams = 1440;
  constexpr double kStep_rad = 2.0 * kPi / kGridBeams;
  LaserScan scan{lidar.utime, static_cast<float>(-kPi), static_cast<float>(kStep_rad),
                 std::vector<float>(kGridBeams, 0.0f)};
  for (std::size_t i = 0; i < *num_beams; ++i) {
    if (!IsAngle(lidar.thetas[i])) return std::nullopt;
    const float range_m = lidar.ranges[i];
    if (!(range_m > 0.0f)) continue;
    const double angle_rad = WrapAngle(-static_cast<double>(lidar.thetas[i]));
    const auto beam = static_cast<std::size_t>(std::lround((angle_rad + kPi) / kStep_rad)) % kGridBeams;
    float& nearest_m = scan.ranges_m[beam];
    if (nearest_m == 0.0f || range_m < nearest_m) nearest_m = range_m;
  }
  return scan;
}

std::optional<LaserScan> DecodeLaser(std::string_view message) {
  const std::int64_t fingerprint = Fingerprint(message);
  if (fingerprint == bot_core::planar_lidar_t::getHash()) return DecodePlanarLidar(message);
  if (fingerprint == botlab::lidar_t::getHash()) return DecodeBotlabLidar<botlab::lidar_t>(message);
  if (fingerprint == botlab::lidar_nranges_t::getHash()) return DecodeBotlabLidar<botlab::lidar_nranges_t>(message);
  return std::nullopt;
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
  throw std::runtime_error(
      fmt::format("{} has no laser messages (bot_core.planar_lidar_t or botlab.lidar_t){}; its channels: {}", path,
                  wanted, ListChannels(num_events, num_lasers)));
}

}  // namespace

LcmLogSource::LcmLogSource(const std::string& path, const std::string& channel)
    : log_(path), channel_(FindLaserChannel(path, channel)) {}

std::optional<LaserScan> LcmLogSource::Next() {
  while (const auto event = log_.Next()) {
    if (event->channel != channel_) {
      if (IsLaser(event->data)) ++counts_["other_channel"];
      continue;
    }
    std::optional<LaserScan> scan = DecodeLaser(event->data);
    if (!scan || scan->utime < 0) {
      ++counts_["bad_message"];
    } else if (!utimes_.insert(scan->utime).second) {
      ++counts_["utime_repeated"];
    } else {
      return scan;
    }
  }
  return std::nullopt;
}

std::map<std::string, std::int64_t> LcmLogSource::Counts() const {
  std::map<std::string, std::int64_t> counts = counts_;
  counts["bad_event"] = log_.num_bad_events();
  counts["truncated"] = log_.truncated() ? 1 : 0;
  return counts;
}

}  // namespace crsm
