// Lockstep on a network that delays packets, and so reorders them, and loses and doubles some.

#include <fmt/core.h>
#include <poll.h>

#include <atomic>
#include <thread>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "faults.hpp"
#include "packets.hpp"
#include "run_on_threads.hpp"

using namespace crsm;

namespace {

using Clock = std::chrono::steady_clock;
constexpr double kLost = 0.05, kLate = 0.3, kTwice = 0.05;  // shares of the copies
constexpr double kLongest_ms = 500.0;

/// Passes packets between processes that are each on a bus of their own.
class Relay {
 public:
  Relay(std::uint64_t seed, const std::vector<std::string>& urls) : random_(seed) {
    for (const std::string& url : urls) {
      ports_.push_back(PortOf(url));
      listeners_.push_back(Listen(ports_.back()));
    }
    thread_ = std::thread([this] { Run(); });
  }
  ~Relay() {
    ended_ = true;
    thread_.join();
    for (const pollfd& listener : listeners_) close(listener.fd);
  }
  Relay(const Relay&) = delete;

 private:
  struct Packet {
    int port;
    std::string bytes;
  };

  static pollfd Listen(int port) {
    const int descriptor = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const int yes = 1;
    const sockaddr_in place = GroupAt(port);
    ip_mreq membership{};
    membership.imr_multiaddr = place.sin_addr;
    if (setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        bind(descriptor, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0 ||
        setsockopt(descriptor, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) {
      throw std::runtime_error("the relay cannot listen");
    }
    return {descriptor, POLLIN, 0};
  }

  void Run() {
    while (!ended_) {
      poll(listeners_.data(), listeners_.size(), 1);
      for (std::size_t i = 0; i < listeners_.size(); ++i) Take(listeners_[i].fd, ports_[i]);
      for (; !waiting_.empty() && waiting_.begin()->first <= Clock::now(); waiting_.erase(waiting_.begin())) {
        sender_.Send(waiting_.begin()->second.bytes, waiting_.begin()->second.port);
      }
    }
  }

  void Take(int descriptor, int from_port) {
    std::string bytes(65536, '\0');
    while (true) {
      sockaddr_in source{};
      socklen_t size = sizeof source;
      const auto num =
          recvfrom(descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&source), &size);
      if (num < 0) return;
      if (sender_.IsMine(source)) continue;
      for (const int port : ports_) {
        if (port != from_port) Forward({port, bytes.substr(0, static_cast<std::size_t>(num))});
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
  RawSender sender_;
  std::multimap<Clock::time_point, Packet> waiting_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

/// Maps a log with all that a seed brings. Throws std::runtime_error where that is not the map in offline/.
void MapThroughRelay(const TemporaryFolder& folder, const std::string& log, std::uint64_t seed) {
  const std::vector<std::string> names{"map_updater",  "loop_closer",  "rrhc_matcher",
                                       "ray_selector", "map_exporter", "laser_publisher"};
  // A bus for each. They are taken until the tests end: those that run one after the other take the same.
  thread_local std::vector<std::string> urls;
  while (urls.size() < names.size()) urls.push_back(MakeBusUrl());
  const std::string name = std::to_string(seed);
  Stack::Options options{.url = urls[0], .out = folder / name};
  for (std::size_t i = 0; i < names.size(); ++i) options.urls[names[i]] = urls[i];
  const Relay relay(seed, urls);
  Stack stack(options);
  const bool success = stack.StartServices() && stack.StartPublisher(log, "max") && stack.Finish();
  const std::string said = stack["laser_publisher"].errors();
  if (!success || said.find("has waited") != std::string::npos) throw std::runtime_error("a process failed: " + said);
  for (const char* file : {"map.png", "trajectory.tum"}) {
    if (ReadFile(folder / name / file) != ReadFile(folder / "offline" / file)) {
      throw std::runtime_error(std::string(file) + " is another");
    }
  }
}

void MapThroughRelays(std::size_t num_runs, int num_at_once, const std::vector<LaserScan>& scans) {
  const TemporaryFolder folder;
  const std::string log = folder.Write(scans, "run.lcm");
  folder.Map(log, "offline");
  RunOnThreads(
      num_runs, num_at_once, [&](std::size_t i) { MapThroughRelay(folder, log, i + 1); },
      [](std::size_t i) { return fmt::format("seed {}", i + 1); });
}

}  // namespace

TEST_CASE("a network that delays by up to 500 ms, reorders, doubles and loses packets costs lockstep time only") {
  MapThroughRelays(8, 8, TakeScans("sim:demo", 40));  // some packets come so late that ten scans were matched since
}

TEST_CASE("delays", "[.][fault][delays]") {
  const auto num_runs = ByEffort(8, 200);
  MapThroughRelays(num_runs, 20, TakeScans("sim:demo", ByEffort(40, 60)));
  fmt::print("{} runs: same map\n", num_runs);
}
