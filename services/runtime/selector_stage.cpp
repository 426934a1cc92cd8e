#include "services/runtime/selector_stage.hpp"

#include <utility>

#include "services/runtime/conversions.hpp"

namespace crsm {

SelectorStage::SelectorStage(const CommandLine& command_line, Select select)
    : service_(command_line),
      select_(std::move(select)),
      watch_(service_, command_line.parameters().scan, kLaserChannel),
      scans_(service_.counters()) {
  service_.TakeRole(kSelectorRole);
  service_.bus().Subscribe<bot_core::planar_lidar_t>(
      kLaserChannel,
      [this](const bot_core::planar_lidar_t& message) {
        LaserScan scan = FromMessage(message);
        watch_.Hear(scan);
        scans_.Push(std::move(scan));
      },
      [this](std::span<const std::uint8_t> bytes) { watch_.Refuse(bytes); });
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
