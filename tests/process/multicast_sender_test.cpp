#include "services/bus/multicast_sender.hpp"

#include <poll.h>

#include <lcm/lcm-cpp.hpp>
#include <string>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

/// On a bus of its own.
class Line {
 public:
  explicit Line(const std::vector<std::string>& channels)
      : sender(MulticastSender::Open(address_)), receiver(MulticastSocket::Open(address_)) {  // joins the group later
    REQUIRE((sender && receiver));
    REQUIRE(receiver->Listen(channels));
  }

  void Add(const std::string& channel, const std::string& bytes) {
    const auto place = sender->Add(channel, bytes.size());
    REQUIRE(place.size() == bytes.size());
    std::copy(bytes.begin(), bytes.end(), place.begin());
  }

  /// What has come: channels and messages.
  std::vector<std::pair<std::string, std::string>> Receive() {
    constexpr int kLongest_ms = 2000;
    pollfd waited{receiver->descriptor(), POLLIN, 0};
    std::vector<std::pair<std::string, std::string>> received;
    if (poll(&waited, 1, kLongest_ms) <= 0) return received;
    while (const auto message = receiver->Receive()) {
      REQUIRE(message->sender.known());
      received.emplace_back(std::string(message->channel), std::string(message->bytes.begin(), message->bytes.end()));
    }
    return received;
  }

 private:
  const MulticastAddress address_ = [] {
    MulticastAddress address;
    address.port = std::stoi(MakeBusUrl().substr(std::string("udpm://239.255.76.67:").size()));
    address.buffer_bytes = 100'000;
    return address;
  }();

 public:
  std::unique_ptr<MulticastSender> sender;
  std::unique_ptr<MulticastSocket> receiver;
};

}  // namespace

TEST_CASE("messages that are sent together come in their order, on the channels that are listened to") {
  Line line({"A", "B"});
  std::vector<std::pair<std::string, std::string>> sent;
  for (int i = 0; i < 40; ++i) sent.emplace_back(i % 3 == 0 ? "A" : "B", "message " + std::to_string(i));
  for (const auto& [channel, bytes] : sent) line.Add(channel, bytes);
  line.Add("C", "is not listened to");
  CHECK(line.sender->Flush() == 0);
  CHECK(line.Receive() == sent);
  CHECK(line.sender->Flush() == 0);  // nothing more
  line.Add("A", "");
  CHECK(line.sender->Flush() == 0);
  using Received = std::vector<std::pair<std::string, std::string>>;
  CHECK(line.Receive() == Received{{"A", ""}});
}

TEST_CASE("what fits into one packet is sent, and longer messages are left to LCM") {
  Line line({"A"});
  constexpr std::size_t kMost = 65497;
  CHECK(MulticastSender::Fits("A", kMost));
  CHECK_FALSE(MulticastSender::Fits("A", kMost + 1));
  CHECK_FALSE(MulticastSender::Fits(std::string(64, 'a'), 1));
  const std::string longest(kMost, 'x');
  line.Add("A", longest);
  CHECK(line.sender->Flush() == 0);
  const auto received = line.Receive();
  REQUIRE(received.size() == 1);
  CHECK((received.front().second == longest));
}
