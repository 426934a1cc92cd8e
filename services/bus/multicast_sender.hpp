#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "services/bus/multicast_socket.hpp"

namespace crsm {

/// Sends messages by LCM's UDP multicast protocol, several with one system call: who listens to more than one of them
/// wakes up once. Source: LCM's udpm protocol, messages in one packet.
class MulticastSender {
 public:
  /// nullptr if the kernel refuses it.
  static std::unique_ptr<MulticastSender> Open(const MulticastAddress& address);
  ~MulticastSender();
  MulticastSender(const MulticastSender&) = delete;

  /// Whether a message fits into one packet.
  static bool Fits(std::string_view channel, std::size_t num_bytes);

  /// A message that the next Flush sends: the place for its bytes. It must fit.
  std::span<std::uint8_t> Add(std::string_view channel, std::size_t num_bytes);

  /// Sends what was added. 0, or why not all could be sent (errno).
  int Flush();

 private:
  explicit MulticastSender(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
  sockaddr_in place_{};             ///< of the group
  std::uint32_t num_messages_ = 0;  ///< so far
  std::vector<std::vector<std::uint8_t>> packets_;
  std::size_t num_waiting_ = 0;  ///< of them: the others are room for more
};

}  // namespace crsm
