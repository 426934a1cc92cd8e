#include "services/runtime/multicast_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

#include "services/runtime/socket_filter.hpp"

namespace crsm {
namespace {

constexpr std::size_t kHeaderBytes = 8;  // magic and sequence number; behind them the channel, a NUL, the message

template <class Value>
bool SetOption(int socket, int level, int name, const Value& value) {
  return setsockopt(socket, level, name, &value, sizeof value) == 0;
}

}  // namespace

std::unique_ptr<MulticastSocket> MulticastSocket::Open(const MulticastAddress& address) {
  std::unique_ptr<MulticastSocket> opened(new MulticastSocket(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)));
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
  return AttachFilter(descriptor_, MakeChannelFilter(channels, Packets::kWhole));
}

std::optional<MulticastSocket::Message> MulticastSocket::Receive() {
  const ssize_t size = recv(descriptor_, packet_.data(), packet_.size(), MSG_DONTWAIT);
  if (size < 0) return std::nullopt;
  // The filter lets only whole messages through.
  const auto channel = packet_.begin() + kHeaderBytes;
  const auto end = packet_.begin() + size;
  const auto channel_end = std::find(channel, end, 0);
  return Message{{reinterpret_cast<const char*>(&*channel), static_cast<std::size_t>(channel_end - channel)},
                 {channel_end + 1, end}};
}

}  // namespace crsm
