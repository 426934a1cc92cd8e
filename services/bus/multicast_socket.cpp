#include "services/bus/multicast_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

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

void MulticastSocket::Await(int timeout_ms) {
  if (has_more()) return;
  if (timeout_ms <= 0) return Read(MSG_DONTWAIT);
  if (timeout_ms != timeout_ms_) {
    const timeval timeout{timeout_ms / 1000, timeout_ms % 1000 * 1000};
    if (SetOption(descriptor_, SOL_SOCKET, SO_RCVTIMEO, timeout)) timeout_ms_ = timeout_ms;
  }
  Read(MSG_WAITFORONE);
}

void MulticastSocket::Read(int flags) {
  std::array<mmsghdr, kAtOnce> headers{};
  std::array<iovec, kAtOnce> parts{};
  std::array<sockaddr_in, kAtOnce> sources{};
  for (std::size_t i = 0; i < kAtOnce; ++i) {
    parts[i] = {packets_.get() + i * kLargestPacket, kLargestPacket};
    headers[i].msg_hdr.msg_iov = &parts[i];
    headers[i].msg_hdr.msg_iovlen = 1;
    headers[i].msg_hdr.msg_name = &sources[i];
    headers[i].msg_hdr.msg_namelen = sizeof sources[i];
  }
  const int num = recvmmsg(descriptor_, headers.data(), kAtOnce, flags, nullptr);
  next_ = 0;
  num_read_ = static_cast<std::size_t>(std::max(num, 0));
  all_read_ = num_read_ < kAtOnce;
  for (std::size_t i = 0; i < num_read_; ++i) {
    read_[i] = {{sources[i].sin_addr.s_addr, ntohs(sources[i].sin_port)}, headers[i].msg_len};
  }
}

std::optional<MulticastSocket::Message> MulticastSocket::Receive() {
  while (has_more() || !std::exchange(all_read_, false)) {
    if (!has_more()) Read(MSG_DONTWAIT);
    if (!has_more()) continue;
    const std::size_t at = next_++;
    auto message = Parse({packets_.get() + at * kLargestPacket, read_[at].num_bytes});
    if (!message) continue;  // the filter lets only whole messages through
    message->sender = read_[at].sender;
    return message;
  }
  return std::nullopt;
}

}  // namespace crsm
