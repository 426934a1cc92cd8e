#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/bus/sole_sender.hpp"

namespace crsm {

/// Where LCM's multicast is, and how much of it the kernel is to keep until it is read.
struct MulticastAddress {
  std::string group = "239.255.76.67";
  int port = 7667;
  int buffer_bytes = 2097152;  ///< a burst of map parts fits
  int ttl = 0;                 ///< 0: messages do not leave the host, and none from others are heard
};

/// A socket that receives the messages of LCM's UDP multicast protocol that come in one packet, in the thread that
/// handles them. LCM's own way, by a thread that wakes another through a pipe, costs twice the wake-ups and twice the
/// system calls.
class MulticastSocket {
 public:
  struct Message {
    Sender sender;
    std::string_view channel;
    std::span<const std::uint8_t> bytes;
  };

  /// A packet's message, if it is one that is whole in this packet. Its sender is not known here.
  static std::optional<Message> Parse(std::span<const std::uint8_t> packet);

  /// Receives nothing before Listen. nullptr if the kernel refuses any of it, also a buffer of that size: a thread that
  /// empties a small one at once is the better way then.
  static std::unique_ptr<MulticastSocket> Open(const MulticastAddress& address);
  ~MulticastSocket();
  MulticastSocket(const MulticastSocket&) = delete;

  /// From now on messages on these channels are received. False if the kernel refuses so many.
  bool Listen(const std::vector<std::string>& channels);

  /// To wait on.
  int descriptor() const { return descriptor_; }

  /// The next message that is there; good until the next call.
  std::optional<Message> Receive();

 private:
  MulticastSocket(int descriptor, int ttl) : descriptor_(descriptor), ttl_(ttl) {}
  bool Prepare(const MulticastAddress& address);

  int descriptor_;
  int ttl_;
  std::vector<std::uint8_t> packet_ = std::vector<std::uint8_t>(65536);  // no UDP packet is larger
};

}  // namespace crsm
