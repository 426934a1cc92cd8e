#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace crsm {

/// Where a UDP packet came from. On its own host a sender cannot pretend to be another one: the port is that of its
/// socket, which no other process can have while the first lives.
struct Sender {
  std::uint32_t address = 0;  ///< IPv4, in the order of the network; 0: this host, which has no address of its own
  std::uint16_t port = 0;     ///< 0: the sender is not known
  bool known() const { return port != 0; }
  friend auto operator<=>(const Sender&, const Sender&) = default;

  std::string Describe() const;
};

}  // namespace crsm
