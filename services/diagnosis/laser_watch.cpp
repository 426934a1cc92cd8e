#include "services/diagnosis/laser_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "services/base/printable.hpp"
#include "services/wire/message_types.hpp"
#include "services/wire/pose_types.hpp"

namespace crsm {
namespace {

/// "4.2 s".
std::string FormatSeconds(LaserSilence::Time::duration duration) {
  return fmt::format("{:.1f} s", std::chrono::duration<double>(duration).count());
}

}  // namespace

LaserWatch::LaserWatch(Service& service, const CommandLine& command_line, std::string channel)
    : service_(service),
      channel_(service.bus().prefix() + std::move(channel)),
      messages_(LaserMessagesOf(command_line)),
      judge_(command_line.parameters().scan),
      silence_(Clock::now()),
      search_(service_.bus(), channel_),
      study_(command_line.parameters()) {
  service_.bus().Subscribe<service_status_t>(
      ServiceStatusChannel("laser_publisher"),
      [this](const service_status_t& status) { silence_.HearPublisher(Clock::now(), status.state); });
  service_.bus().SubscribeBytes(kOdometryChannel, [this](std::span<const std::uint8_t> bytes) {
    const auto odometry = handedness_told_ ? std::nullopt : DecodePose(bytes);
    if (!odometry) return true;  // the matcher counts what is wrong with it
    if (!handedness_) handedness_.emplace();
    handedness_->Add(*odometry);
    return true;
  });
}

void LaserWatch::Hear(const LaserScan& scan, const LaserType& type) {
  const auto now = Clock::now();
  NoteArrival(now);
  left_out_.Take();
  for (const std::string& complaint : judge_.Look(scan)) SayOf(complaint);
  if (handedness_) JudgeHandedness(scan, type);
  study_.Add(scan);
}

void LaserWatch::JudgeHandedness(const LaserScan& scan, const LaserType& type) {
  using Verdict = HandednessJudge::Verdict;
  handedness_->Add(scan);
  const Verdict verdict = handedness_->verdict();
  if (verdict == Verdict::kUnknown) return;
  if (verdict == Verdict::kMirrored) SayOf("scans " + DescribeMirrored(kOdometryChannel, type, messages_));
  handedness_told_ = true;
  handedness_.reset();
}

void LaserWatch::Refuse(std::span<const std::uint8_t> bytes) {
  const auto now = Clock::now();
  NoteArrival(now);
  const auto news = left_out_.LeaveOut(now);
  if (!news) return;
  SayOf(fmt::format("{} of the last {} messages are left out: {}", news->num_left_out, news->num_all,
                    DescribeRefusedLaser(bytes)));
}

void LaserWatch::Poll() {
  const auto now = Clock::now();
  for (const std::string& finding : study_.TakeFindings()) SayOf(finding);
  if (silence_.Look(now) == LaserSilence::Verdict::kFellSilent) {
    SaySeldom("no scan for 3 s: does the laser's driver still run, and is its cable plugged in?", now);
  }
  if (!silence_.IsMissing(now) || others_came_) return search_.Rest();
  for (const std::string& found : search_.Look(silence_.ever_heard(), now)) SayOf(found);
}

/// Something came on the laser's channel.
void LaserWatch::NoteArrival(Clock::time_point now) {
  const bool is_first = !silence_.ever_heard();
  const auto silent = silence_.Hear(now);
  if (!silent) return;
  if (!is_first) return SaySeldom(fmt::format("the laser is back after {}", FormatSeconds(*silent)), now);
  if (search_.has_said_so())
    SaySeldom(fmt::format("the laser is there, {} after the start", FormatSeconds(*silent)), now);
}

/// Scans of two lasers would become one map that is of neither.
void LaserWatch::RefuseSender(const Sender& refused, const std::optional<Sender>& used) {
  SayOnce(fmt::format(
      "scans come from {}, too, and are left out: those of {} are used: stop one of them, or give it a channel of its "
      "own",
      refused.Describe(), used ? used->Describe() : "the publisher"));
}

void LaserWatch::SayOnce(const std::string& complaint) {
  constexpr std::size_t kMost = 20;  // of what the network makes us say
  if (complaint.empty() || said_.size() >= kMost || !said_.insert(complaint).second) return;
  SayOf(complaint);
}

/// What comes and goes.
void LaserWatch::SaySeldom(const std::string& line, Clock::time_point now) {
  if (const auto passed = coming_and_going_.Pass(line, now)) SayOf(*passed);
}

void LaserWatch::SayOf(const std::string& complaint) const {
  Say(fmt::format("{}: {}: {}", service_.name(), MakePrintable(channel_), complaint));
}

}  // namespace crsm
