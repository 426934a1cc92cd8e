#include "services/bus/sender.hpp"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <netinet/in.h>

#include <array>

namespace crsm {

std::string Sender::Describe() const {
  if (!known()) return "an unknown sender";
  std::array<char, INET_ADDRSTRLEN> text{};
  const in_addr network{address};
  inet_ntop(AF_INET, &network, text.data(), text.size());
  return fmt::format("{}:{}", text.data(), port);
}

}  // namespace crsm
