#include "services/bus/multicast_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "services/bus/socket_filter.hpp"

namespace crsm {
namespace {

constexpr std::size_t kHeaderBytes = 8;  // magic and sequence number; behind them the channel, a NUL, the message
constexpr std::array<std::uint8_t, 4> kMagic{0x4c, 0x43, 0x30, 0x32};

template <class Value>
bool SetOption(int socket, int level, int name, const Value& value) {
  return setsockopt(socket, level, name, &value, sizeof value) == 0;
}

}  // namespace

std::unique_ptr<MulticastSocket> MulticastSocket::Open(const MulticastAddress& address) {
  std::unique_ptr<MulticastSocket> opened(
      new MulticastSocket(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0), address.ttl));
  return opened->Prepare(address) ? std::move(opened) : nullptr;
}

MulticastSocket::~MulticastSocket() {
  if (descriptor_ >= 0) close(descriptor_);
}

bool MulticastSocket::Prepare(const MulticastAddress& address) {
  int granted_bytes = 0;
  socklen_t size = sizeof granted_bytes;
  if (!SetOption(descriptor_, SOL_SOCKET, SO_RCVBUF, address.buffer_bytes) ||
      getsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &granted_bytes, &size) != 0 ||
      granted_bytes / 2 < address.buffer_bytes) {  // the kernel doubles what it grants, for its own needs
    return false;
  }
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(static_cast<std::uint16_t>(address.port));
  ip_mreq membership{};
  if (inet_pton(AF_INET, address.group.c_str(), &membership.imr_multiaddr) != 1) return false;
  place.sin_addr = membership.imr_multiaddr;
  return Listen({}) && SetOption(descriptor_, SOL_SOCKET, SO_REUSEADDR, 1) &&
         bind(descriptor_, reinterpret_cast<sockaddr*>(&place), sizeof place) == 0 &&
         SetOption(descriptor_, IPPROTO_IP, IP_ADD_MEMBERSHIP, membership);
}

bool MulticastSocket::Listen(const std::vector<std::string>& channels) {
  return AttachFilter(descriptor_, MakeChannelFilter(channels, {Packets::kWhole, HostsHeardAt(ttl_)}));
}

std::optional<MulticastSocket::Message> MulticastSocket::Parse(std::span<const std::uint8_t> packet) {
  if (packet.size() <= kHeaderBytes || !std::equal(kMagic.begin(), kMagic.end(), packet.begin())) return std::nullopt;
  const auto named = packet.subspan(kHeaderBytes);
  const auto channel_end = std::find(named.begin(), named.end(), 0);
  if (channel_end == named.end()) return std::nullopt;
  const auto channel_size = static_cast<std::size_t>(channel_end - named.begin());
  return Message{{}, {reinterpret_cast<const char*>(named.data()), channel_size}, named.subspan(channel_size + 1)};
}

std::optional<MulticastSocket::Message> MulticastSocket::Receive() {
  while (true) {
    sockaddr_in source{};
    socklen_t source_size = sizeof source;
    const ssize_t size = recvfrom(descriptor_, packet_.data(), packet_.size(), MSG_DONTWAIT,
                                  reinterpret_cast<sockaddr*>(&source), &source_size);
    if (size < 0) return std::nullopt;
    auto message = Parse({packet_.data(), static_cast<std::size_t>(size)});
    if (!message) continue;  // the filter lets only whole messages through
    message->sender = {source.sin_addr.s_addr, ntohs(source.sin_port)};
    return message;
  }
}

}  // namespace crsm
