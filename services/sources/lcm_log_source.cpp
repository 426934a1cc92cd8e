#include "services/sources/lcm_log_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "common/logs/sweep_stamps.hpp"
#include "common/math/nearest_name.hpp"
#include "services/base/printable.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/laser_types.hpp"
#include "services/wire/message_types.hpp"
#include "services/wire/pose_types.hpp"

namespace crsm {

namespace {

bool IsLaser(std::span<const std::uint8_t> bytes) { return FindLaserType(bytes) != nullptr; }

/// What is looked for in a log.
struct Wanted {
  bool (*is)(std::span<const std::uint8_t> bytes);
  const char* word;
  std::string types;
};

/// "ENCODERS (12), LASER (3, laser)".
std::string ListChannels(const std::map<std::string, std::int64_t>& num_events,
                         const std::map<std::string, std::int64_t>& num_wanted, const char* word) {
  std::vector<std::string> entries;
  for (const auto& [channel, count] : num_events) {
    const std::string mark = num_wanted.count(channel) ? fmt::format(", {}", word) : "";
    entries.push_back(fmt::format("{} ({}{})", channel, count, mark));
  }
  return ListPrintable(entries);
}

/// The channel to take: `channel` if it has a message that is wanted, or the first that has one if `channel` is empty.
std::string FindChannel(const std::string& path, const std::string& channel, const Wanted& wanted) {
  LcmEventLog log(path);
  std::map<std::string, std::int64_t> num_events;
  std::map<std::string, std::int64_t> num_wanted;
  constexpr std::size_t kMaxChannels = 1000;  // a hostile log may have a name for each event
  while (const auto event = log.Next()) {
    const bool is_wanted = wanted.is(Bytes(event->data));
    if (is_wanted && (channel.empty() || channel == event->channel)) return event->channel;
    if (num_events.size() >= kMaxChannels && !num_events.count(event->channel)) continue;
    ++num_events[event->channel];
    if (is_wanted) ++num_wanted[event->channel];
  }
  const std::string where = channel.empty() ? "" : fmt::format(" on channel {}", channel);
  std::vector<std::string> names;
  for (const auto& entry : num_wanted) names.push_back(entry.first);
  throw std::runtime_error(fmt::format("{} has no {} messages ({}){}; its channels: {}{}", path, wanted.word,
                                       wanted.types, where, ListChannels(num_events, num_wanted, wanted.word),
                                       MakePrintable(SuggestName(channel, names))));
}

std::string FindLaserChannel(const std::string& path, const std::string& channel) {
  return FindChannel(path, channel, {IsLaser, "laser", LaserTypeNames()});
}

/// The one that is named; else "robot1/ODOMETRY" for "robot1/LASER".
std::string FindOdometryChannel(const std::string& path, const std::string& laser_channel,
                                const std::string& odometry) {
  if (!odometry.empty()) {
    return FindChannel(path, odometry, {IsPoseMessage, "pose", "bot_core.pose_t, mbot_lcm_msgs.pose2D_t"});
  }
  const std::string_view laser = kLaserChannel;
  const bool is_ours = laser_channel.ends_with(laser);
  return (is_ours ? laser_channel.substr(0, laser_channel.size() - laser.size()) : "") + kOdometryChannel;
}

}  // namespace

LcmLogSource::LcmLogSource(const std::string& path, const LaserChoice& laser, const LaserMessageOptions& messages,
                           const std::string& odometry)
    : messages_(messages),
      log_(path),
      channel_(FindLaserChannel(path, laser.channel)),
      frames_(laser.frame),
      odometry_channel_(FindOdometryChannel(path, channel_, odometry)) {
  StudyFirstScans(path, laser.frame);
}

/// Reads ahead. Throws where the first scans are of several lasers, or none of the log is of the one that is wanted.
void LcmLogSource::StudyFirstScans(const std::string& path, const std::string& wanted) {
  constexpr int kMostEvents = 10'000;  // of a log with few scans, if there is nothing to look for
  LaserFrames frames(wanted);
  std::vector<std::pair<std::int64_t, std::int64_t>> stamps;  // of scans without times, and when they were recorded
  LcmEventLog log(path);
  for (int i = 0; !frames.AreKnown() && (i < kMostEvents || !wanted.empty()); ++i) {
    const auto event = log.Next();
    if (!event) break;
    if (event->channel != channel_) continue;
    const auto reading = DecodeLaser(Bytes(event->data), messages_);
    if (!reading || !frames.Take(reading->frame)) continue;
    clock_.Study(reading->scan, event->recorded_utime);
    const bool says_times = messages_.scan.beam_times && !reading->scan.times_s.empty();
    if (!says_times) stamps.emplace_back(reading->scan.utime, event->recorded_utime);
  }
  SweepStamps sweep_stamps;
  for (const auto& [stamp, recorded_utime] : stamps) {
    sweep_stamps.Study(clock_.ToMicroseconds(stamp), recorded_utime);
  }
  const double sweep_s = messages_.scan.sweep_s;
  if (sweep_stamps.AreOfFirstBeam(sweep_s)) sweep_us_ = std::llround(1e6 * std::abs(sweep_s));
  const std::string complaint = frames.Complaint();
  if (!complaint.empty()) throw std::runtime_error(fmt::format("{}: {}: {}", path, channel_, complaint));
}

std::optional<LaserScan> LcmLogSource::Next() {
  while (!scans_.NextIsReady() && ReadEvent()) {
  }
  return scans_.Next();
}

bool LcmLogSource::ReadEvent() {
  constexpr std::size_t kMostOtherChannels = 20;  // a hostile log may have a name for each event
  const auto event = log_.Next();
  if (!event) return false;
  if (event->channel == channel_) {
    TakeScan(*event);
  } else if (IsLaser(Bytes(event->data))) {
    ++counts_["other_channel"];
    if (other_channels_.size() < kMostOtherChannels) other_channels_.insert(event->channel);
  } else if (IsPoseMessage(Bytes(event->data))) {
    TakePose(event->channel, event->data);
  }
  return true;
}

void LcmLogSource::TakePose(const std::string& channel, std::string_view data) {
  constexpr std::size_t kMostChannels = 4;
  const bool is_odometry = channel == odometry_channel_;
  auto pose = DecodePose(Bytes(data));
  if (pose) pose->utime = clock_.ToMicroseconds(pose->utime);
  if (is_odometry && pose) scans_.Add(*pose);
  if (is_odometry && !pose) ++counts_["bad_odometry"];
  if (pose && (handedness_.size() < kMostChannels || handedness_.count(channel))) handedness_[channel].Add(*pose);
}

void LcmLogSource::TakeScan(const LcmEventLog::Event& event) {
  const std::span<const std::uint8_t> bytes = Bytes(event.data);
  std::optional<LaserReading> reading = DecodeLaser(bytes, messages_);
  if (!reading) {
    ++counts_["bad_message"];
    if (first_refusal_.empty() && IsLaser(bytes)) first_refusal_ = DescribeRefusedLaser(bytes);
    return;
  }
  if (!frames_.Take(reading->frame)) {
    ++counts_["other_frame"];
    return;
  }
  laser_ = FindLaserType(bytes);
  if (thinned_.empty()) thinned_ = reading->thinned;
  if (contradiction_.empty()) contradiction_ = reading->contradiction;
  const auto utime = clock_.TimeOf(reading->scan, event.recorded_utime);
  const std::int64_t latest = std::numeric_limits<std::int64_t>::max() - sweep_us_;
  reading->scan.utime = std::min(utime.value_or(reading->scan.utime), latest) + sweep_us_;
  for (auto& [pose_channel, judge] : handedness_) judge.Add(reading->scan);
  if (!utime || !scans_.Add(std::move(reading->scan))) ++counts_["utime_repeated"];
}

std::vector<std::string> LcmLogSource::Complaints() const {
  std::vector<std::string> complaints = scans_.Complaints(channel_, counts_, first_refusal_, "utime");
  for (const std::string& complaint : {frames_.Complaint(), thinned_, contradiction_, clock_.Complaint("utime")}) {
    if (!complaint.empty()) complaints.push_back(fmt::format("{}: {}", channel_, complaint));
  }
  if (sweep_us_ > 0) {
    complaints.push_back(
        fmt::format("{}: utime is that of a scan's first beam, as the times of recording show: {:.3g} s are added",
                    channel_, 1e-6 * static_cast<double>(sweep_us_)));
  }
  if (!other_channels_.empty()) {
    const std::vector<std::string> others(other_channels_.begin(), other_channels_.end());
    complaints.push_back(fmt::format("the scans are those on {}; there {} on {}, too: --laser-channel takes {}",
                                     channel_, others.size() == 1 ? "is a laser" : "are lasers", ListPrintable(others),
                                     others.size() == 1 ? "it" : "one of them"));
  }
  for (const auto& [pose_channel, judge] : handedness_) {
    if (judge.verdict() != HandednessJudge::Verdict::kMirrored) continue;
    complaints.push_back(
        fmt::format("the scans on {} {}", channel_, DescribeMirrored(pose_channel, *laser_, messages_)));
    break;
  }
  return complaints;
}

std::vector<std::string> LcmLogSource::OdometryNotes() const {
  const std::int64_t num = scans_.num_with_odometry();
  if (num > 0)
    return {fmt::format("gives odometry to {} of {} scans ({})", num, scans_.num_scans(), odometry_channel_)};
  if (handedness_.count(odometry_channel_)) {
    return {
        fmt::format("has odometry ({}), but gives it to no scan: {}", odometry_channel_, scans_.ExplainNoOdometry())};
  }
  std::vector<std::string> others;
  for (const auto& [pose_channel, judge] : handedness_) {
    if (pose_channel != kTruePoseChannel) others.push_back(pose_channel);
  }
  if (others.empty()) return {};
  return {
      fmt::format("has no odometry that can be used: there is no pose on {}; --odometry-topic may name another "
                  "channel with poses: {}",
                  odometry_channel_, ListPrintable(others))};
}

std::map<std::string, std::int64_t> LcmLogSource::Counts() const {
  std::map<std::string, std::int64_t> counts = counts_;
  counts["bad_event"] = log_.num_bad_events();
  counts["truncated"] = log_.truncated() ? 1 : 0;
  return counts;
}

}  // namespace crsm
