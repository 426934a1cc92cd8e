#pragma once

#include <array>
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
  int ttl = 0;  ///< routers that a message may pass and one more; 0: it stays on the host, and others are not heard
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

  /// Waits for a message, and reads it and those that are there by then, with one system call. At most that long, or
  /// until a signal comes; 0: not at all.
  void Await(int timeout_ms);

  /// The next message that is there; good until the next call. One that comes while others are read is left to the next
  /// time: nothing is read just to learn that there is no more.
  std::optional<Message> Receive();
  /// Whether some were read that Receive has not given yet.
  bool has_more() const { return next_ < num_read_; }

 private:
  static constexpr std::size_t kAtOnce = 16;
  static constexpr std::size_t kLargestPacket = 65536;

  MulticastSocket(int descriptor, int ttl) : descriptor_(descriptor), ttl_(ttl) {}
  bool Prepare(const MulticastAddress& address);
  void Read(int flags);

  int descriptor_;
  int ttl_;
  std::unique_ptr<std::uint8_t[]> packets_ =  // of which the system gives memory only where something is read
      std::make_unique_for_overwrite<std::uint8_t[]>(kAtOnce * kLargestPacket);
  struct Packet {
    Sender sender;
    std::size_t num_bytes = 0;
  };
  std::array<Packet, kAtOnce> read_;
  std::size_t num_read_ = 0;
  std::size_t next_ = 0;
  bool all_read_ = false;  ///< there were no more
  int timeout_ms_ = 0;     ///< that the kernel knows of
};

}  // namespace crsm
