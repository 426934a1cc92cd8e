#include "services/bus/multicast_sender.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "services/wire/channels.hpp"

namespace crsm {
namespace {

constexpr std::size_t kMostBytes = 65499;  // of channel, NUL and message: longer ones LCM sends in fragments

}  // namespace

std::unique_ptr<MulticastSender> MulticastSender::Open(const MulticastAddress& address) {
  std::unique_ptr<MulticastSender> opened(new MulticastSender(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)));
  sockaddr_in& place = opened->place_;
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(address.port));
  const auto ttl = static_cast<std::uint8_t>(std::min(address.ttl, 255));
  const bool ready = inet_pton(AF_INET, address.group.c_str(), &place.sin_addr) == 1 &&
                     setsockopt(opened->descriptor_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) == 0;
  return ready ? std::move(opened) : nullptr;
}

MulticastSender::~MulticastSender() {
  if (descriptor_ >= 0) close(descriptor_);
}

bool MulticastSender::Fits(std::string_view channel, std::size_t num_bytes) {
  return channel.size() <= kLongestChannel && channel.size() + 1 + num_bytes <= kMostBytes;
}

std::span<std::uint8_t> MulticastSender::Add(std::string_view channel, std::size_t num_bytes) {
  if (num_waiting_ == packets_.size()) packets_.emplace_back();
  std::vector<std::uint8_t>& packet = packets_[num_waiting_++];
  const std::uint32_t number = num_messages_++;
  packet = {0x4c, 0x43, 0x30, 0x32};
  for (int shift = 24; shift >= 0; shift -= 8) packet.push_back(static_cast<std::uint8_t>(number >> shift));
  packet.insert(packet.end(), channel.begin(), channel.end());
  packet.push_back(0);
  packet.resize(packet.size() + num_bytes);
  return std::span(packet).last(num_bytes);
}

int MulticastSender::Flush() {
  constexpr std::size_t kAtOnce = 64;
  int error = 0;
  for (std::size_t sent = 0; sent < num_waiting_;) {
    std::array<mmsghdr, kAtOnce> headers{};
    std::array<iovec, kAtOnce> parts{};
    const std::size_t num = std::min(kAtOnce, num_waiting_ - sent);
    for (std::size_t i = 0; i < num; ++i) {
      // Each names the group: a socket that is connected to it reaches nobody on this host who joined it later.
      headers[i].msg_hdr.msg_name = &place_;
      headers[i].msg_hdr.msg_namelen = sizeof place_;
      parts[i] = {packets_[sent + i].data(), packets_[sent + i].size()};
      headers[i].msg_hdr.msg_iov = &parts[i];
      headers[i].msg_hdr.msg_iovlen = 1;
    }
    const int num_taken = sendmmsg(descriptor_, headers.data(), static_cast<unsigned>(num), 0);
    if (num_taken < 0 && errno == EINTR) continue;
    if (num_taken < 0) error = errno;  // of the first of them; those behind it may go
    sent += static_cast<std::size_t>(std::max(num_taken, 1));
  }
  num_waiting_ = 0;
  return error;
}

}  // namespace crsm
