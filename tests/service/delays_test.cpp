// Lockstep on a network that delays packets, and so reorders them, and loses and doubles some. scripts/fault delays is
// the same, longer.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <map>
#include <thread>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

using Clock = std::chrono::steady_clock;
constexpr double kLost = 0.05, kLate = 0.3, kTwice = 0.05;  // shares of the copies
constexpr double kLongest_ms = 500.0;

sockaddr_in GroupAt(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = inet_addr("239.255.76.67");
  return address;
}

/// Passes packets between processes that are each on a bus of their own.
class Relay {
 public:
  Relay(std::uint64_t seed, const std::vector<int>& ports) : random_(seed), ports_(ports) {
    for (const int port : ports) listeners_.push_back(Listen(port));
    const unsigned char ttl = 0;
    REQUIRE(setsockopt(sender_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) == 0);
    sockaddr_in own{};
    own.sin_family = AF_INET;
    REQUIRE(bind(sender_, reinterpret_cast<sockaddr*>(&own), sizeof own) == 0);
    socklen_t size = sizeof own;
    REQUIRE(getsockname(sender_, reinterpret_cast<sockaddr*>(&own), &size) == 0);
    own_port_ = own.sin_port;
    thread_ = std::thread([this] { Run(); });
  }
  ~Relay() {
    ended_ = true;
    thread_.join();
    for (const pollfd& listener : listeners_) close(listener.fd);
    close(sender_);
  }
  Relay(const Relay&) = delete;

 private:
  struct Packet {
    int port;
    std::vector<std::uint8_t> bytes;
  };

  static pollfd Listen(int port) {
    const int descriptor = socket(AF_INET, SOCK_DGRAM, 0);
    const int yes = 1;
    const sockaddr_in place = GroupAt(port);
    ip_mreq membership{};
    membership.imr_multiaddr = place.sin_addr;
    REQUIRE(setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0);
    REQUIRE(bind(descriptor, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0);
    REQUIRE(setsockopt(descriptor, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0);
    return {descriptor, POLLIN, 0};
  }

  void Run() {
    while (!ended_) {
      poll(listeners_.data(), listeners_.size(), 1);
      for (std::size_t i = 0; i < listeners_.size(); ++i) Take(listeners_[i].fd, ports_[i]);
      for (; !waiting_.empty() && waiting_.begin()->first <= Clock::now(); waiting_.erase(waiting_.begin())) {
        const Packet& packet = waiting_.begin()->second;
        const sockaddr_in to = GroupAt(packet.port);
        sendto(sender_, packet.bytes.data(), packet.bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
      }
    }
  }

  void Take(int descriptor, int from_port) {
    std::vector<std::uint8_t> bytes(65536);
    while (true) {
      sockaddr_in source{};
      socklen_t size = sizeof source;
      const auto num =
          recvfrom(descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&source), &size);
      if (num < 0) return;
      if (source.sin_port == own_port_) continue;
      for (const int port : ports_) {
        if (port != from_port) Forward({port, {bytes.begin(), bytes.begin() + num}});
      }
    }
  }

  void Forward(const Packet& packet) {
    if (random_.Uniform(0.0, 1.0) < kLost) return;
    Hold(packet, random_.Uniform(0.0, 1.0) < kLate);
    if (random_.Uniform(0.0, 1.0) < kTwice) Hold(packet, true);
  }

  void Hold(const Packet& packet, bool late) {
    const std::chrono::duration<double, std::milli> delay(late ? random_.Uniform(0.0, kLongest_ms) : 0.0);
    waiting_.emplace(Clock::now() + std::chrono::duration_cast<Clock::duration>(delay), packet);
  }

  Random random_;
  std::vector<int> ports_;
  std::vector<pollfd> listeners_;
  int sender_ = socket(AF_INET, SOCK_DGRAM, 0);
  in_port_t own_port_ = 0;  ///< in the order of the network
  std::multimap<Clock::time_point, Packet> waiting_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

int PortOf(const std::string& url) { return std::stoi(url.substr(url.rfind(':') + 1)); }

}  // namespace

TEST_CASE("a network that delays by up to 500 ms, reorders, doubles and loses packets costs lockstep time only") {
  const TemporaryFolder folder;
  WriteScans(TakeScans("sim:demo", 25, 2), folder / "run.lcm");
  REQUIRE(Run("slam_offline", {folder / "run.lcm", "--out", folder / "offline"}, folder / "log") == 0);
  std::map<std::string, std::string> urls;
  std::vector<int> ports;
  for (const char* name :
       {"map_updater", "loop_closer", "rrhc_matcher", "ray_selector", "map_exporter", "laser_publisher"}) {
    urls[name] = MakeBusUrl();
    ports.push_back(PortOf(urls[name]));
  }
  const Relay relay(1, ports);
  const std::string out = folder / "out";
  Process updater("map_updater", {"--lockstep", "--lcm-url", urls["map_updater"]}, folder / "log");
  Process closer("loop_closer", {"--lcm-url", urls["loop_closer"]}, folder / "log");
  Process matcher("rrhc_matcher", {"--lockstep", "--lcm-url", urls["rrhc_matcher"]}, folder / "log");
  Process selector("ray_selector", {"--lcm-url", urls["ray_selector"]}, folder / "log");
  Process exporter("map_exporter", {"--out", out, "--lcm-url", urls["map_exporter"]}, folder / "log");
  for (Process* process : {&updater, &closer, &matcher, &selector, &exporter}) REQUIRE(process->AwaitReady());
  Process publisher("laser_publisher", {folder / "run.lcm", "--rate", "max", "--lcm-url", urls["laser_publisher"]},
                    folder / "log");
  CHECK(publisher.AwaitExit() == 0);
  INFO(publisher.errors());
  for (Process* process : {&exporter, &selector, &matcher, &closer, &updater}) CHECK(process->Interrupt() == 0);
  for (const char* file : {"map.png", "trajectory.tum"}) {
    INFO(file);
    CHECK(ReadFile(folder / "out" / file) == ReadFile(folder / "offline" / file));
  }
}
