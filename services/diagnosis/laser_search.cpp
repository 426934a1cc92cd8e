#include "services/diagnosis/laser_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "services/base/printable.hpp"
#include "services/wire/channels.hpp"
#include "services/wire/laser_types.hpp"
#include "services/wire/message_types.hpp"

namespace crsm {
namespace {

constexpr std::size_t kMostChannels = 20;  // that are told of: the names come from the network

/// Whether a channel is one of the stack's own, or LCM's, on which no laser can be.
bool HasNoLaser(const std::string& channel) {
  return channel == "LCM_SELF_TEST" ||  // on which each program that listens greets itself at its start
         channel.find("SERVICE_STATUS/") != std::string::npos ||
         std::any_of(std::begin(kChannelsOfStack), std::end(kChannelsOfStack),
                     [&](const char* name) { return channel.ends_with(name); });
}

std::string DescribeChannel(const std::pair<const std::string, std::uint64_t>& channel) {
  return fmt::format("{} ({})", MakePrintable(channel.first), NameOfType(channel.second));
}

}  // namespace

std::vector<std::string> LaserSearch::Look(bool was_heard, Clock::time_point now) {
  constexpr auto kPause = std::chrono::seconds(4);
  if (!until_) {
    if (now >= next_) Listen(now);
    return {};
  }
  Hear();
  if (now < *until_) return {};
  std::vector<std::string> said = Conclude(was_heard);
  Rest();
  next_ = now + kPause;
  return said;
}

void LaserSearch::Rest() {
  if (!until_) return;
  until_.reset();
  all_channels_.reset();
  lasers_.clear();
  others_.clear();
}

/// The sockets of the bus hear no other channel than those that are subscribed to.
void LaserSearch::Listen(Clock::time_point now) {
  constexpr auto kListenFor = std::chrono::milliseconds(1000);
  until_ = now + kListenFor;
  if (!bus_.multicast()) return;
  MulticastAddress address = *bus_.multicast();
  address.buffer_bytes = 100'000;  // which every kernel grants: what is lost of it comes again
  all_channels_ = MulticastSocket::Open(address);
  if (all_channels_ && !all_channels_->Listen({"*"})) all_channels_.reset();
}

void LaserSearch::Hear() {
  constexpr int kMostMessages = 1000;  // at once: who sends faster than they are read must not keep the laser waiting
  for (int i = 0; all_channels_ && i < kMostMessages; ++i) {
    const auto message = all_channels_->Receive();
    if (!message) return;
    const std::string channel(message->channel);
    if (channel == channel_ || HasNoLaser(channel)) continue;
    const std::uint64_t fingerprint = Fingerprint(message->bytes);
    auto& heard = FindLaserType(fingerprint) ? lasers_ : others_;
    if (heard.size() < kMostChannels) heard[channel] = fingerprint;
  }
}

std::vector<std::string> LaserSearch::Conclude(bool was_heard) {
  std::vector<std::string> said;
  if (!was_heard && !std::exchange(has_said_so_, true)) {
    said.push_back("nothing came since the start; " + DescribeBus());
  }
  for (const auto& laser : lasers_) {
    if (named_.size() >= kMostChannels || !named_.insert(laser.first).second) continue;
    said.push_back(fmt::format("there is a laser on {}: {}", DescribeChannel(laser), DescribeMend(laser.first)));
  }
  return said;
}

std::string LaserSearch::DescribeBus() {
  if (!all_channels_) return "does the laser's driver run with the same --lcm-url? lcm-spy shows what is on this bus";
  if (lasers_.empty() && others_.empty()) {
    return "no other channel is on this bus: does the laser's driver run with the same --lcm-url?";
  }
  std::vector<std::string> listed;
  std::map<std::string, std::uint64_t> all = others_;
  all.insert(lasers_.begin(), lasers_.end());
  std::transform(all.begin(), all.end(), std::back_inserter(listed), DescribeChannel);
  for (const auto& laser : lasers_) named_.insert(laser.first);
  const std::string mend = lasers_.empty()
                               ? fmt::format("the laser's driver must publish on {}", MakePrintable(channel_))
                               : DescribeMend(lasers_.begin()->first);
  return fmt::format("this bus has {}: {}", fmt::join(listed, ", "), mend);
}

/// A laser is there, but not where it was looked for.
std::string LaserSearch::DescribeMend(const std::string& channel) const {
  const std::string& prefix = bus_.prefix();
  const std::string name = channel_.substr(prefix.size());
  if (channel.ends_with(name)) {
    return fmt::format("did you mean --channel-prefix \"{}\"?",
                       MakePrintable(channel.substr(0, channel.size() - name.size())));
  }
  if (!channel.starts_with(prefix))
    return fmt::format("did you mean {} without --channel-prefix?", MakePrintable(channel));
  return fmt::format("did you mean --laser-channel \"{}\"?", MakePrintable(channel.substr(prefix.size())));
}

}  // namespace crsm
