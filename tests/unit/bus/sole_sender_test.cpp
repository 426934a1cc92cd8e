#include "services/bus/sole_sender.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <vector>

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
  std::vector<Sender> dead = {};
  RoleHolder otherwise = RoleHolder::kNobody;  ///< where `holder` is not known
  std::optional<Sender> holder = {};           ///< of the role
  int num_looks = 0;
  SoleSender sole{[this](const Sender& sender) {
                    ++num_looks;
                    return !holder ? otherwise : *holder == sender ? RoleHolder::kSender : RoleHolder::kAnother;
                  },
                  [this](const Sender& sender, SoleSender::Clock::time_point, SoleSender::Clock::time_point) {
                    return std::find(dead.begin(), dead.end(), sender) == dead.end();
                  }};
  SoleSender::Clock::time_point now{1h};

  SoleSender::Verdict Hear(const Sender& sender, std::chrono::milliseconds later = 0ms) {
    return sole.Judge(sender, now += later);
  }
};

}  // namespace

TEST_CASE("who has the role is believed at once, and nobody else, whoever comes first") {
  Channel channel{.holder = kOne};
  CHECK(channel.Hear(kOther) == kRefused);
  CHECK(channel.Hear(kOne) == kBelieved);
  for (int i = 0; i < 100; ++i) {
    CHECK(channel.Hear(kOther, 50ms) == kRefused);
    CHECK(channel.Hear(kOne) == kBelieved);
  }
}

TEST_CASE("where nobody has the role, the first is believed at once, and for as long as it lives") {
  Channel channel;
  channel.otherwise = GENERATE(RoleHolder::kNobody, RoleHolder::kUnknown);
  CHECK(channel.Hear(kOne) == kBelieved);
  for (int i = 0; i < 100; ++i) CHECK(channel.Hear(kOther, 50ms) == kRefused);
  CHECK(channel.Hear(kOne) == kBelieved);
  channel.dead = {kOne};
  CHECK(channel.Hear(kOther, 100ms) == kChanged);
  CHECK(channel.Hear(kOther) == kBelieved);
}

TEST_CASE("who takes the role is believed at once instead of one that was first, and its stand-in is not") {
  Channel channel;
  CHECK(channel.Hear(kOther) == kBelieved);
  channel.holder = kOne;
  CHECK(channel.Hear(kOne) == kChanged);
  CHECK(channel.Hear(kOther, 100ms) == kRefused);
  channel.holder = kThird;  // it has ended, and was started again
  CHECK(channel.Hear(kThird) == kChanged);
  CHECK(channel.Hear(kOne, 250ms) == kRefused);
}

TEST_CASE("who had the role is not believed any more, whether nobody has it now or another that has said nothing yet") {
  Channel channel{.holder = kOne};
  CHECK(channel.Hear(kOne) == kBelieved);
  channel.holder = GENERATE(std::optional<Sender>(), std::optional(kThird));  // kOne's port may be another process's
  CHECK(channel.Hear(kOne, 250ms) == kRefused);
  CHECK(channel.Hear(kOne, 1ms) == kRefused);
  channel.holder = kThird;
  CHECK(channel.Hear(kThird) == kChanged);
  CHECK(channel.Hear(kOne, 250ms) == kRefused);
}

TEST_CASE("when the holder of the role has gone for long, one without the role is believed, and it is said") {
  Channel channel{.holder = kOne};
  CHECK(channel.Hear(kOne) == kBelieved);
  channel.holder = std::nullopt;
  channel.dead = {kOne};
  CHECK(channel.Hear(kOther) == kRefused);
  CHECK(channel.Hear(kOther, 4900ms) == kRefused);
  CHECK(channel.Hear(kOther, 100ms) == kChanged);
}

TEST_CASE("a holder of the role stays believed while it cannot be asked for") {
  Channel channel{.holder = kOne};
  CHECK(channel.Hear(kOne) == kBelieved);
  channel.holder = std::nullopt;
  channel.otherwise = RoleHolder::kUnknown;
  CHECK(channel.Hear(kOther, 250ms) == kRefused);
  CHECK(channel.Hear(kOne, 250ms) == kBelieved);
}

TEST_CASE("while the holder of the role is kept from answering, who was believed stays, and nobody else is") {
  Channel channel{.otherwise = RoleHolder::kBusy};
  CHECK(channel.Hear(kOne) == kRefused);
  channel.holder = kOne;
  CHECK(channel.Hear(kOne, 1s) == kBelieved);
  channel.holder.reset();
  for (int i = 0; i < 100; ++i) {
    CHECK(channel.Hear(kOther, 500ms) == kRefused);
    CHECK(channel.Hear(kOne) == kBelieved);
  }
}

TEST_CASE("a flood costs few looks, and does not keep the holder of the role out") {
  Channel channel{.holder = kOne};
  for (int i = 0; i < 10'000; ++i) {
    if (i == 5000) CHECK(channel.Hear(kOne) == kBelieved);
    if (i != 5000) channel.Hear(kOther, 1ms);
  }
  CHECK(channel.num_looks < 110);
  for (int i = 0; i < 1000; ++i) channel.Hear(kOne, 1ms);
  CHECK(channel.num_looks < 120);
}

TEST_CASE("a flood from many ports does not keep a new holder of the role out for a moment") {
  Channel channel{.holder = kOne};
  for (int i = 0; i < 2000; ++i) {
    const auto port = static_cast<std::uint16_t>(2000 + i % 64);  // whatever looks are shared out by
    CHECK(channel.Hear({htonl(INADDR_LOOPBACK), port}, 1ms) == kRefused);
  }
  CHECK(channel.Hear(kOne) == kBelieved);
  CHECK(channel.num_looks < 1500);
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
