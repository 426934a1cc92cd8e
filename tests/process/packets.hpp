#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <stdexcept>
#include <string>

namespace crsm {

inline int PortOf(const std::string& url) { return std::stoi(url.substr(url.rfind(':') + 1)); }

/// Of LCM's multicast.
inline sockaddr_in GroupAt(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = inet_addr("239.255.76.67");
  return address;
}

/// Sends UDP packets as they are, past LCM.
class RawSender {
 public:
  explicit RawSender(unsigned char ttl = 0) {
    sockaddr_in own{};
    own.sin_family = AF_INET;
    socklen_t size = sizeof own;
    if (setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0 ||
        bind(socket_, reinterpret_cast<sockaddr*>(&own), sizeof own) != 0 ||
        getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size) != 0) {
      throw std::runtime_error("no packets can be sent");
    }
    own_port_ = own.sin_port;
  }
  ~RawSender() { close(socket_); }
  RawSender(const RawSender&) = delete;

  void Send(const std::string& packet, int port) const {
    const sockaddr_in to = GroupAt(port);
    if (sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to) !=
        static_cast<ssize_t>(packet.size())) {
      throw std::runtime_error("a packet cannot be sent");
    }
  }
  bool IsMine(const sockaddr_in& source) const { return source.sin_port == own_port_; }

 private:
  int socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  in_port_t own_port_ = 0;  ///< in the order of the network
};

/// A fragment of LCM's UDP protocol, version 1.3.1. rest: in the first one the channel, a zero and the beginning of the
/// message; in the others what follows.
struct Fragment {
  std::uint32_t sequence = 0;
  std::uint32_t message_bytes = 0;
  std::uint32_t offset = 0;
  std::uint32_t number = 0;
  std::uint32_t num_fragments = 2;
  std::string rest = {};

  std::string Encode() const {
    std::string packet;
    for (const std::uint32_t word : {0x4c433033u, sequence, message_bytes, offset, number << 16 | num_fragments}) {
      for (int shift = 24; shift >= 0; shift -= 8) packet.push_back(static_cast<char>(word >> shift));
    }
    return packet + rest;
  }
};

/// Two fragments that LCM 1.3.1 writes outside of their message (lcm#628): the place of the second wraps at 32 bits.
inline void SendWrappingFragments(const RawSender& sender, int port, const std::string& channel,
                                  std::uint32_t sequence) {
  sender.Send(
      Fragment{.sequence = sequence, .message_bytes = 1000, .rest = channel + '\0' + std::string(500, 'x')}.Encode(),
      port);
  sender.Send(
      Fragment{
          .sequence = sequence, .message_bytes = 1000, .offset = 0xffffff00, .number = 1, .rest = std::string(512, 'x')}
          .Encode(),
      port);
}

}  // namespace crsm
