#include "services/bus/multicast_socket.hpp"

#include <string>

#include "catch.hpp"

using namespace crsm;

namespace {

/// The channel and the bytes of a packet's message; nothing if it has none.
std::optional<std::pair<std::string, std::string>> Parse(const std::string& packet) {
  const auto message = MulticastSocket::Parse({reinterpret_cast<const std::uint8_t*>(packet.data()), packet.size()});
  if (!message) return std::nullopt;
  return std::pair(std::string(message->channel), std::string(message->bytes.begin(), message->bytes.end()));
}

const std::string kHead("LC02\0\0\0\7", 8);

}  // namespace

TEST_CASE("a packet of LCM is a channel, and what stands behind its end") {
  using Parsed = std::pair<std::string, std::string>;
  CHECK(Parse(kHead + std::string("LASER\0data\0more", 15)) == Parsed{"LASER", std::string("data\0more", 9)});
  CHECK(Parse(kHead + std::string("LASER\0", 6)) == Parsed{"LASER", ""});
  CHECK(Parse(kHead + std::string(1, '\0')) == Parsed{"", ""});
}

TEST_CASE("what has no channel, or is something else, is no message") {
  CHECK_FALSE(Parse(""));
  for (std::size_t size = 0; size <= kHead.size(); ++size) CHECK_FALSE(Parse(kHead.substr(0, size)));
  CHECK_FALSE(Parse(kHead + "LASER"));
  CHECK_FALSE(Parse("LC03" + kHead.substr(4) + std::string("LASER\0data", 10)));
}
