#include "services/stages/selector_stage.hpp"

#include <fmt/core.h>

#include <utility>

#include "common/logs/left_out.hpp"
#include "services/base/usage_error.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/laser_types.hpp"

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

}  // namespace

SelectorStage::SelectorStage(const CommandLine& command_line, Select select)
    : service_(command_line),
      select_(std::move(select)),
      watch_(service_, command_line, LaserChannel(command_line.settings())),
      frames_(command_line.settings().laser_frame),
      scans_(service_.counters()) {
  service_.TakeRole(kSelectorRole);
  service_.bus().SubscribeBytes(LaserChannel(command_line.settings()),
                                [this, options = LaserMessagesOf(command_line)](std::span<const std::uint8_t> bytes) {
                                  std::optional<LaserReading> reading = DecodeLaser(bytes, options);
                                  if (!reading) {
                                    watch_.Refuse(bytes);
                                    service_.counters().Add("bad_message");
                                    service_.SetNumLeftOut(CountLeftOut(service_.counters().counts()));
                                    return false;
                                  }
                                  const bool is_wanted = frames_.Take(reading->frame);
                                  if (frames_.num_scans() % LaserFrames::kEnough == 0)
                                    watch_.SayOnce(frames_.Complaint());
                                  if (!is_wanted) {
                                    watch_.HearOther();
                                    service_.counters().Add("other_frame");
                                    return true;
                                  }
                                  watch_.SayOnce(reading->thinned);
                                  watch_.SayOnce(reading->contradiction);
                                  watch_.Hear(reading->scan, *FindLaserType(bytes));
                                  scans_.Push(std::move(reading->scan));
                                  return true;
                                });
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
