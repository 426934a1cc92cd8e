#include "services/stages/selector_stage.hpp"

#include <fmt/core.h>

#include <utility>

#include "common/logs/left_out.hpp"
#include "services/base/usage_error.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/conversions.hpp"

namespace crsm {
namespace {

std::string LaserChannel(const Settings& settings) {
  const std::string& channel = settings.laser_channel;
  if (channel.find('*') != std::string::npos || settings.channel_prefix.size() + channel.size() > kLongestChannel) {
    throw UsageError(
        fmt::format("--laser-channel {}: must name one channel, without *, in at most {} characters with the prefix",
                    channel, kLongestChannel));
  }
  return channel.empty() ? kLaserChannel : channel;
}

/// Of who may send on a channel. Only on LASER is that a process of ours.
SoleSender::FindRole RoleOn(const std::string& channel, const Bus& bus) {
  if (channel != kLaserChannel) return [](const Sender&) { return RoleHolder::kNobody; };
  return [&bus](const Sender& sender) { return bus.FindHolder(kPublisherRole, sender); };
}

/// Whether a driver still sends: one that is silent gives way to another.
bool Sends(const Sender& sender, Clock::time_point last_heard, Clock::time_point now) {
  constexpr auto kSilence = std::chrono::seconds(3);  // as LaserWatch says it
  return now - last_heard < kSilence && SenderLives(sender, last_heard, now);
}

}  // namespace

SelectorStage::SelectorStage(const CommandLine& command_line, Select select)
    : service_(command_line),
      select_(std::move(select)),
      watch_(service_, command_line, LaserChannel(command_line.settings())),
      frames_(command_line.settings().laser_frame),
      laser_sender_(RoleOn(LaserChannel(command_line.settings()), service_.bus()), Sends),
      scans_(service_.counters()) {
  service_.TakeRole(kSelectorRole);
  service_.bus().SubscribeBytes(LaserChannel(command_line.settings()),
                                [this, options = LaserMessagesOf(command_line)](std::span<const std::uint8_t> bytes) {
                                  return Receive(bytes, options);
                                });
}

/// False where it is no message of a laser.
bool SelectorStage::Receive(std::span<const std::uint8_t> bytes, const LaserMessageOptions& options) {
  std::optional<LaserReading> reading = DecodeLaser(bytes, options);
  if (!reading) {
    RefuseJunk(bytes);
    return false;
  }
  const bool is_wanted = frames_.Take(reading->frame);
  if (frames_.num_scans() % LaserFrames::kEnough == 0) watch_.SayOnce(frames_.Complaint());
  if (!is_wanted) {
    watch_.HearOther();
    service_.counters().Add("other_frame");
    return true;
  }
  if (!IsOfTheLaser()) return true;
  watch_.SayOnce(reading->thinned);
  watch_.SayOnce(reading->contradiction);
  watch_.Hear(reading->scan, *FindLaserType(bytes));
  scans_.Push(std::move(reading->scan));
  return true;
}

/// What is no scan was left out of the recording, unless somebody else sends the scans.
void SelectorStage::RefuseJunk(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kMostOthers = 64;
  const Sender& sender = service_.bus().sender();
  if (laser_ == sender) {
    ++num_junk_;
  } else if (junk_of_others_.size() < kMostOthers || junk_of_others_.contains(sender)) {
    ++junk_of_others_[sender];
  } else {
    ++junk_of_others_[Sender()];
  }
  if (!laser_ || laser_ == sender) watch_.Refuse(bytes);
  CountJunk();
}

/// Whether the message that is being handled is of the one whose scans are used.
bool SelectorStage::IsOfTheLaser() {
  const Sender& sender = service_.bus().sender();
  if (laser_sender_.Judge(sender, Clock::now()) == SoleSender::Verdict::kRefused) {
    watch_.RefuseSender(sender, laser_);
    service_.counters().Add("scans_refused");
    return false;
  }
  if (laser_ == sender) return true;
  laser_ = sender;
  num_junk_ += std::exchange(junk_of_others_[sender], 0);
  CountJunk();
  return true;
}

/// While nobody has sent a scan, it may be the laser that sends no scans.
void SelectorStage::CountJunk() {
  std::int64_t num_of_others = 0;
  for (const auto& [sender, num] : junk_of_others_) num_of_others += num;
  service_.counters().Set("bad_message", laser_ ? num_junk_ : num_of_others);
  service_.counters().Set("messages_refused", laser_ ? num_of_others : 0);
  service_.SetNumLeftOut(CountLeftOut(service_.counters().counts()));
}

void SelectorStage::Run() {
  service_.Run([this] {
    watch_.Poll();
    if (scans_.empty()) return true;
    Answer(scans_.front());
    scans_.Pop();
    return scans_.empty();
  });
}

void SelectorStage::Answer(const LaserScan& scan) {
  const auto start = Clock::now();
  if (last_answer_ && last_answer_->utime == scan.utime) {
    service_.counters().Add("resent");
  } else {
    last_answer_ = ToMessage(select_(scan));
    service_.counters().Add("handled");
    if (last_answer_->num_rays == 0) service_.counters().Add("scan_without_rays");
    service_.SetState("selecting");
  }
  service_.bus().Publish(kCriticalRaysChannel, *last_answer_);
  service_.RecordLatency(start);
}

}  // namespace crsm
