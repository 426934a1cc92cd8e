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

constexpr std::size_t kMostChannels = 20;  // that are told of: the names come from the network

/// Whether a channel is one of the stack's own, on which no laser can be.
bool IsOurs(const std::string& channel) {
  return channel.find("SERVICE_STATUS/") != std::string::npos ||
         std::any_of(std::begin(kChannelsOfStack), std::end(kChannelsOfStack),
                     [&](const char* name) { return channel.ends_with(name); });
}

}  // namespace

LaserWatch::LaserWatch(Service& service, const CommandLine& command_line, std::string channel)
    : service_(service),
      channel_(service.bus().prefix() + std::move(channel)),
      messages_(LaserMessagesOf(command_line)),
      judge_(command_line.parameters().scan),
      silence_(Clock::now()),
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
  silence_.Hear(Clock::now());
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
  silence_.Hear(now);
  const auto news = left_out_.LeaveOut(now);
  if (!news) return;
  SayOf(fmt::format("{} of the last {} messages are left out: {}", news->num_left_out, news->num_all,
                    DescribeRefusedLaser(bytes)));
}

void LaserWatch::Poll() {
  const auto now = Clock::now();
  for (const std::string& finding : study_.TakeFindings()) SayOf(finding);
  switch (silence_.Look(now)) {
    case LaserSilence::Verdict::kNothingYet:
      return ListenToAll();
    case LaserSilence::Verdict::kFellSilent:
      return SayOf("no scan for 3 s: does the laser's driver still run, and is its cable plugged in?");
    case LaserSilence::Verdict::kNone:
      break;
  }
  if (!listen_until_) return;
  while (all_channels_) {
    const auto message = all_channels_->Receive();
    if (!message) break;
    const std::string channel(message->channel);
    if (heard_.size() < kMostChannels && !IsOurs(channel)) heard_[channel] = Fingerprint(message->bytes);
  }
  if (silence_.ever_heard() || now >= *listen_until_) {
    if (!silence_.ever_heard() && !others_came_) SayNothingCame();
    listen_until_.reset();
    all_channels_.reset();
  }
}

void LaserWatch::SayOnce(const std::string& complaint) {
  constexpr std::size_t kMost = 20;  // of what the network makes us say
  if (complaint.empty() || said_.size() >= kMost || !said_.insert(complaint).second) return;
  SayOf(complaint);
}

void LaserWatch::SayOf(const std::string& complaint) const {
  Say(fmt::format("{}: {}: {}", service_.name(), MakePrintable(channel_), complaint));
}

/// The sockets that we have hear no other channel. For a moment this one hears all.
void LaserWatch::ListenToAll() {
  constexpr auto kListenFor = std::chrono::milliseconds(1000);
  listen_until_ = Clock::now() + kListenFor;
  if (!service_.bus().multicast()) return;
  MulticastAddress address = *service_.bus().multicast();
  address.buffer_bytes = 100'000;  // which every kernel grants: what is lost of it comes again
  all_channels_ = MulticastSocket::Open(address);
  if (all_channels_ && !all_channels_->Listen({"*"})) all_channels_.reset();
}

void LaserWatch::SayNothingCame() { SayOf(fmt::format("nothing came since the start; {}", DescribeBus())); }

/// A laser is there, but not where it was looked for.
std::string LaserWatch::DescribeOtherChannel(const std::string& channel) const {
  const std::string& prefix = service_.bus().prefix();
  const std::string name = channel_.substr(prefix.size());
  if (channel.ends_with(name)) {
    return fmt::format("did you mean --channel-prefix \"{}\"?",
                       MakePrintable(channel.substr(0, channel.size() - name.size())));
  }
  if (!channel.starts_with(prefix))
    return fmt::format("did you mean {} without --channel-prefix?", MakePrintable(channel));
  return fmt::format("did you mean --laser-channel \"{}\"?", MakePrintable(channel.substr(prefix.size())));
}

std::string LaserWatch::DescribeBus() const {
  if (!all_channels_) return "does the laser's driver run with the same --lcm-url? lcm-spy shows what is on this bus";
  if (heard_.empty()) return "no other channel is on this bus: does the laser's driver run with the same --lcm-url?";
  std::vector<std::string> listed;
  std::string mend = fmt::format("the laser's driver must publish on {}", MakePrintable(channel_));
  for (const auto& [channel, fingerprint] : heard_) {
    listed.push_back(fmt::format("{} ({})", MakePrintable(channel), NameOfType(fingerprint)));
    if (FindLaserType(fingerprint)) mend = DescribeOtherChannel(channel);
  }
  return fmt::format("this bus has {}: {}", fmt::join(listed, ", "), mend);
}

}  // namespace crsm
