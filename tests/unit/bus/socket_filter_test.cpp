#include "services/bus/socket_filter.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "catch.hpp"
#include "lcm_events.hpp"

using namespace crsm;

namespace {

using Bytes = std::string;

/// A message in one packet. channel: with its NUL.
Bytes Message(const Bytes& channel, const Bytes& data = "data") {
  return BigEndian(0x4c433032, 4) + BigEndian(7, 4) + channel + data;
}

struct Fragment {
  std::uint32_t size = 3000;  ///< of the whole message [bytes]
  std::uint32_t offset = 0;
  std::uint16_t number = 0;
  std::uint16_t num_fragments = 3;
  Bytes rest = Bytes("LASER\0", 6) + Bytes(1000, 'x');

  Bytes Encode() const {
    return BigEndian(0x4c433033, 4) + BigEndian(7, 4) + BigEndian(size, 4) + BigEndian(offset, 4) +
           BigEndian(number, 2) + BigEndian(num_fragments, 2) + rest;
  }
};

/// A UDP socket of its own on the loopback, which lets through these channels, and one that sends to it.
class Loopback {
 public:
  explicit Loopback(const std::vector<std::string>& channels = {"LASER", "END"}, const Passage& passage = {}) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(bind(receiver_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    socklen_t size = sizeof address;
    REQUIRE(getsockname(receiver_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    REQUIRE(connect(sender_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    port_ = ntohs(address.sin_port);
    REQUIRE(Filter(channels, passage));
  }
  ~Loopback() {
    close(receiver_);
    close(sender_);
  }
  Loopback(const Loopback&) = delete;

  bool Filter(const std::vector<std::string>& channels, const Passage& passage = {}) {
    return AttachFilter(receiver_, MakeChannelFilter(channels, passage));
  }

  /// Whether the packet arrives before another one that is sent after it, and that no filter here keeps away.
  bool Passes(const Bytes& packet, const Bytes& last = Message(Bytes("END\0", 4), "")) {
    for (const Bytes& bytes : {packet, last}) {
      REQUIRE(send(sender_, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
    }
    const Bytes first = Receive();
    if (first == last && packet != last) return false;
    REQUIRE(first == packet);
    REQUIRE(Receive() == last);
    return true;
  }

  int receiver() const { return receiver_; }
  int port() const { return port_; }

 private:
  Bytes Receive() {
    constexpr int kPatienceMs = 10000;
    pollfd waited{receiver_, POLLIN, 0};
    REQUIRE(poll(&waited, 1, kPatienceMs) == 1);
    Bytes bytes(65536, '\0');
    const ssize_t size = recv(receiver_, bytes.data(), bytes.size(), 0);
    REQUIRE(size >= 0);
    bytes.resize(static_cast<std::size_t>(size));
    return bytes;
  }

  int receiver_ = socket(AF_INET, SOCK_DGRAM, 0);
  int sender_ = socket(AF_INET, SOCK_DGRAM, 0);
  int port_ = 0;
};

Bytes Name(const std::string& channel) { return Bytes(channel.c_str(), channel.size() + 1); }

}  // namespace

TEST_CASE("messages on the channels of the filter pass whole, whatever the length of their names") {
  const std::vector<std::string> channels{"END", "LASER", "robot1/LASER", "A", "LONG", "LASE", std::string(63, 'n')};
  Loopback loopback(channels);
  for (const std::string& channel : channels) {
    INFO(channel);
    CHECK(loopback.Passes(Message(Name(channel))));
    CHECK(loopback.Passes(Message(Name(channel), Bytes(60000, 'x'))));
    CHECK(loopback.Passes(Message(Name(channel), "x")));
    CHECK(loopback.Passes(Fragment{.rest = Name(channel) + Bytes(1000, 'x')}.Encode()));
  }
}

TEST_CASE("a channel that ends in * lets all pass whose names begin so, and * alone lets every message pass") {
  Loopback loopback({"END", "SERVICE_STATUS/*", "SERVICE_STATUS/longer"});
  for (const std::string channel : {"SERVICE_STATUS/", "SERVICE_STATUS/a", "SERVICE_STATUS/rrhc_matcher"}) {
    INFO(channel);
    CHECK(loopback.Passes(Message(Name(channel))));
  }
  for (const std::string channel : {"SERVICE_STATUS", "SERVICE_STATU", "robot1/SERVICE_STATUS/a", "SERVICE_STATUS*"}) {
    INFO(channel);
    CHECK_FALSE(loopback.Passes(Message(Name(channel))));
  }
  REQUIRE(loopback.Filter({"*"}, {Packets::kWhole}));
  CHECK(loopback.Passes(Message(Name("anything"))));
  CHECK_FALSE(loopback.Passes(Fragment{}.Encode()));
}

TEST_CASE("messages on any other channel are dropped") {
  Loopback loopback({"LASER", "MAP_DELTA", "END"});
  for (const std::string channel : {"", "L", "LASE", "LASES", "LASER2", "laser", "robot1/LASER", "POSE", "MAP_DELT",
                                    "MAP_DELTA_2", "XMAP_DELTA", "LCM_SELF_TEST"}) {
    INFO(channel);
    CHECK_FALSE(loopback.Passes(Message(Name(channel))));
    CHECK_FALSE(loopback.Passes(Fragment{.rest = Name(channel) + Bytes(1000, 'x')}.Encode()));
  }
}

TEST_CASE("what is no message of LCM is dropped") {
  Loopback loopback;
  const Bytes message = Message(Name("LASER"), "");
  REQUIRE(loopback.Passes(message));
  for (std::size_t size = 0; size < message.size(); ++size) {  // up to the name without its NUL
    INFO(size);
    CHECK_FALSE(loopback.Passes(message.substr(0, size)));
  }
  CHECK_FALSE(loopback.Passes("LC04" + message.substr(4)));
  CHECK_FALSE(loopback.Passes(Bytes(100, '\0')));
  CHECK_FALSE(loopback.Passes(Bytes(100, '\xff')));
}

TEST_CASE("the later fragments of a message pass if they can be part of one") {
  Loopback loopback;
  const Bytes data(1000, 'x');
  CHECK(loopback.Passes(Fragment{.offset = 1000, .number = 1, .rest = data}.Encode()));
  CHECK(loopback.Passes(Fragment{.offset = 2000, .number = 2, .rest = data}.Encode()));
  CHECK(loopback.Passes(Fragment{.offset = 3000, .number = 2, .rest = ""}.Encode()));
  CHECK_FALSE(loopback.Passes(Fragment{.offset = 3001, .number = 2, .rest = ""}.Encode()));
  constexpr std::uint32_t kMost = kLargestFragmentedMessage;
  CHECK(loopback.Passes(Fragment{.size = kMost, .offset = kMost - 1000, .number = 9, .rest = data}.Encode()));
  for (const std::uint32_t size : {kMost + 1, 1u << 28, 1u << 31, 0xffffffffu}) {
    INFO(size);
    CHECK_FALSE(loopback.Passes(Fragment{.size = size}.Encode()));
    CHECK_FALSE(loopback.Passes(Fragment{.size = size, .offset = 1000, .number = 1, .rest = data}.Encode()));
  }
}

TEST_CASE("fragments that LCM 1.3.1 would write outside of their message are dropped") {
  Loopback loopback;
  // Offset and length together wrap at 32 bits to less than the size.
  for (const std::uint16_t number : {std::uint16_t{0}, std::uint16_t{1}}) {
    CHECK_FALSE(loopback.Passes(Fragment{.size = 1000, .offset = 0xffffff00, .number = number}.Encode()));
  }
  // A header that is cut off, and a first fragment whose channel has no end: the length would be negative.
  for (const Bytes& whole : {Fragment{.rest = Name("LASER")}.Encode(), Fragment{.number = 1, .rest = ""}.Encode()}) {
    REQUIRE(loopback.Passes(whole));
    for (std::size_t size = 0; size < whole.size(); ++size) {
      INFO(size);
      CHECK_FALSE(loopback.Passes(whole.substr(0, size)));
    }
  }
}

TEST_CASE("one of two filters lets through what the other does not") {
  const std::vector<Bytes> whole{Message(Name("LASER"))};
  const std::vector<Bytes> fragments{Fragment{}.Encode(), Fragment{.offset = 1000, .number = 1}.Encode()};
  const std::vector<Bytes> neither{Message(Name("POSE")), Fragment{.offset = 0xffffff00, .number = 1}.Encode()};
  for (const Packets packets : {Packets::kWhole, Packets::kFragments}) {
    Loopback loopback({"LASER"}, {.packets = packets});
    const Bytes last = packets == Packets::kWhole ? whole[0] : fragments[0];
    for (const Bytes& packet : whole) CHECK(loopback.Passes(packet, last) == (packets == Packets::kWhole));
    for (const Bytes& packet : fragments) CHECK(loopback.Passes(packet, last) == (packets == Packets::kFragments));
    for (const Bytes& packet : neither) CHECK_FALSE(loopback.Passes(packet, last));
  }
}

TEST_CASE("a filter takes the place of the one before; one that the kernel refuses leaves none") {
  Loopback loopback;
  CHECK_FALSE(loopback.Passes(Message(Name("POSE"))));
  REQUIRE(loopback.Filter({"LASER", "POSE", "END"}));
  CHECK(loopback.Passes(Message(Name("POSE"))));
  CHECK_FALSE(loopback.Passes(Message(Name("ODOMETRY"))));
  CHECK_FALSE(loopback.Filter(std::vector(1000, std::string(60, 'n'))));
  CHECK(loopback.Passes(Message(Name("ODOMETRY"))));
  CHECK_FALSE(AttachFilter(-1, MakeChannelFilter({"LASER"})));
}

TEST_CASE("the sockets that receive on a port are found, and no others") {
  Loopback one;
  Loopback other;
  CHECK(FindUdpSockets(one.port()) == std::set{one.receiver()});
  CHECK(FindUdpSockets(other.port()) == std::set{other.receiver()});
}
