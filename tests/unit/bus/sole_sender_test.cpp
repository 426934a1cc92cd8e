#include "services/bus/sole_sender.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

#include "catch.hpp"

using namespace crsm;
using namespace std::chrono_literals;
using enum SoleSender::Verdict;

namespace {

const Sender kOne{htonl(INADDR_LOOPBACK), 1001};
const Sender kOther{htonl(INADDR_LOOPBACK), 1002};
const Sender kThird{htonl(INADDR_LOOPBACK), 1003};

/// One channel, and a clock of its own. All senders live but those in `dead`.
struct Channel {
  std::vector<Sender> dead;
  SoleSender sole{SoleSender::kProbation,
                  [this](const Sender& sender, SoleSender::Clock::time_point, SoleSender::Clock::time_point) {
                    return std::find(dead.begin(), dead.end(), sender) == dead.end();
                  }};
  SoleSender::Clock::time_point now{1h};

  SoleSender::Verdict Hear(const Sender& sender, std::chrono::milliseconds later = 0ms) {
    return sole.Judge(sender, now += later);
  }
  /// From now on this one is believed.
  void Begin(const Sender& sender) {
    Hear(sender);
    REQUIRE(Hear(sender, 100ms) == kBelieved);
    REQUIRE(Hear(sender, 2s) == kBelieved);
  }
};

}  // namespace

TEST_CASE("the first sender is believed when it has been the only one for a moment") {
  Channel channel;
  CHECK(channel.Hear(kOne) == kUndecided);
  CHECK(channel.Hear(kOne, 99ms) == kUndecided);
  CHECK(channel.Hear(kOne, 1ms) == kBelieved);
  CHECK(channel.Hear(kOne, 24h) == kBelieved);
  CHECK_FALSE(channel.sole.contested());
}

TEST_CASE("another sender is refused while the first lives, however often it tries") {
  Channel channel;
  channel.Begin(kOne);
  for (int i = 0; i < 100; ++i) CHECK(channel.Hear(kOther, 50ms) == kRefused);
  CHECK(channel.Hear(kOne) == kBelieved);
}

TEST_CASE("of two at the beginning none is believed, and when one has ended the other is") {
  Channel channel;
  CHECK(channel.Hear(kOther) == kUndecided);
  CHECK(channel.Hear(kOne, 5ms) == kRefused);
  CHECK(channel.sole.Judge(kOther, channel.now, false) == kRefused);  // what it sent before
  for (int i = 0; i < 100; ++i) {
    CHECK(channel.Hear(kOther, 50ms) == kRefused);
    CHECK(channel.Hear(kOne) == kRefused);
  }
  CHECK(channel.sole.contested());
  channel.dead = {kOther};
  CHECK(channel.Hear(kOne, 50ms) == kUndecided);
  CHECK(channel.Hear(kOne, 100ms) == kBelieved);
}

TEST_CASE("when another one is heard soon after the first, none of them is believed until one has ended") {
  Channel channel;
  channel.Hear(kOther);
  CHECK(channel.Hear(kOther, 100ms) == kBelieved);
  CHECK(channel.Hear(kOne, 1s) == kRefused);
  CHECK(channel.sole.contested());
  CHECK(channel.Hear(kOther) == kRefused);
  channel.dead = {kOther};
  CHECK(channel.Hear(kOne, 50ms) == kUndecided);
  CHECK(channel.Hear(kOne, 100ms) == kBelieved);
}

TEST_CASE("a sender that was started anew takes the place of the one that ended, after its moment alone") {
  Channel channel;
  channel.Begin(kOne);
  channel.dead = {kOne};
  CHECK(channel.Hear(kOther, 50ms) == kUndecided);
  CHECK(channel.Hear(kThird, 50ms) == kRefused);
  channel.dead.push_back(kThird);
  CHECK(channel.Hear(kOther, 50ms) == kUndecided);
  CHECK(channel.Hear(kOther, 100ms) == kBelieved);
}

TEST_CASE("more senders than any bus has are refused, and none of them stays when it has ended") {
  Channel channel;
  for (std::uint16_t port = 1; port <= 1000; ++port) {
    channel.Hear({kOne.address, port});
    channel.dead.push_back({kOne.address, port});
  }
  CHECK(channel.Hear(kOther, 50ms) == kUndecided);
  CHECK(channel.Hear(kOther, 100ms) == kBelieved);
}

TEST_CASE("a sender of this host lives as long as its socket, and one of another host for two seconds of silence") {
  const SoleSender::Clock::time_point now{1h};
  const int descriptor = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  REQUIRE(bind(descriptor, reinterpret_cast<sockaddr*>(&place), sizeof place) == 0);  // at any address, as LCM's
  socklen_t size = sizeof place;
  REQUIRE(getsockname(descriptor, reinterpret_cast<sockaddr*>(&place), &size) == 0);
  const Sender here{htonl(INADDR_LOOPBACK), ntohs(place.sin_port)};
  const Sender without_network{0, here.port};  // how the kernel names a sender when only the loopback is up
  for (const Sender& sender : {here, without_network}) CHECK(SenderLives(sender, now - 1h, now));
  close(descriptor);
  for (const Sender& sender : {here, without_network}) CHECK_FALSE(SenderLives(sender, now, now));

  const Sender elsewhere{inet_addr("192.0.2.1"), 5000};  // an address of documentation, nobody's
  for (const Sender& sender : {elsewhere, Sender{}}) {
    CHECK(SenderLives(sender, now - 1900ms, now));
    CHECK_FALSE(SenderLives(sender, now - 2100ms, now));
  }
}

TEST_CASE("a sender is described by its address and port") {
  CHECK(kOne.Describe() == "127.0.0.1:1001");
  CHECK(Sender{0, 1001}.Describe() == "0.0.0.0:1001");
  CHECK(Sender{}.Describe() == "an unknown sender");
}
