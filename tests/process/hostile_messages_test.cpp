// Messages that no honest sender sends. Every process reads them, none believes them.

#include <algorithm>
#include <csignal>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <thread>

#include "catch.hpp"
#include "count_finder.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"
#include "wire_messages.hpp"

using namespace crsm;

namespace {

constexpr std::int64_t kFar = std::int64_t{1} << 62;
constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kUtime = 5'000'000;

bot_core::planar_lidar_t MakeLaser(int num_beams = 40) {
  LaserScan scan{kUtime, -1.5f, 3.0f / static_cast<float>(num_beams), {}};
  for (int i = 0; i < num_beams; ++i) scan.ranges_m.push_back(3.0f + 0.01f * static_cast<float>(i % 100));
  return ToMessage(scan);
}

map_delta_t MakeDelta(std::int64_t epoch, std::int64_t version) {
  return {.utime = kUtime, .epoch = epoch, .version = version, .cell_size_m = 0.05, .num_parts = 1};
}

constexpr const char* kStatusOfSomebody = "SERVICE_STATUS/somebody";

service_status_t StatusOf(const std::string& name) { return {.name = name, .version = "1", .state = "at rest"}; }

/// A channel and all that is wrong on it.
struct Channel {
  const char* name;
  std::vector<Bytes> malformed;
  std::int64_t num_sent = 0;
};

/// What goes wrong with any type: nothing there, cut short, too long, another type, counts that are none. Of values
/// that cannot be each type has its own, which tests/unit/wire tries.
template <class Message>
Channel Hostile(const char* name, const Message& good) {
  const Bytes bytes = Encode(good);
  Channel channel{name, {}};
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    channel.malformed.emplace_back(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  }
  channel.malformed.push_back(bytes);
  channel.malformed.back().push_back(0);
  for (const std::uint8_t byte : {std::uint8_t{0x00}, std::uint8_t{0xff}}) {
    channel.malformed.push_back(bytes);
    std::fill_n(channel.malformed.back().begin(), 8, byte);
  }
  constexpr auto kLargest = std::numeric_limits<std::int32_t>::max();
  CountFinder counts;
  counts.Visit(good);
  for (const auto& [at, count] : counts.counts()) {
    for (const std::int32_t hostile : {-1, 1'000'000, 1 << 30, kLargest, -kLargest - 1}) {
      channel.malformed.push_back(WithCount(bytes, at, hostile));
    }
  }
  return channel;
}

std::vector<Channel> MakeChannels() {
  return {Hostile(kLaserChannel, MakeLaser()),
          Hostile(kOdometryChannel, PoseMessage()),
          Hostile(kCriticalRaysChannel, CriticalRaysMessage()),
          Hostile(kScanMatchChannel, ScanMatchMessage()),
          Hostile(kMapDeltaChannel, MapDeltaMessage()),
          Hostile(kScanRequestChannel, ScanRequestMessage()),
          Hostile(kScanAnswerChannel, ScanAnswerMessage()),
          Hostile(kMapRequestChannel, MapRequestMessage()),
          Hostile(kKeyframeChannel, KeyframeMessage()),
          Hostile(kKeyframeRequestChannel, KeyframeRequestMessage()),
          Hostile(kPoseGraphChannel, PoseGraphMessage()),
          Hostile(kStatusOfSomebody, ServiceStatusMessage()),
          Hostile(kMapPageChannel, MapPageMessage()),
          Hostile(kWholeMapChannel, MapPageMessage())};
}

/// Whether every program on the bus has taken all messages out of the kernel's buffer, where more would be lost.
bool KernelIsEmpty(const std::string& url) {
  const int port = std::stoi(url.substr(url.rfind(':') + 1));
  std::ifstream sockets("/proc/net/udp");
  for (std::string line; std::getline(sockets, line);) {
    std::istringstream fields(line);
    std::string number, local, remote, state, queues;
    fields >> number >> local >> remote >> state >> queues;  // address:port in hexadecimal; bytes to send:received
    const bool here = local.find(':') == 8 && std::stoi(local.substr(9), nullptr, 16) == port;
    if (here && queues.substr(queues.find(':') + 1) != "00000000") return false;
  }
  return true;
}

/// Sends bytes as they are, no faster than they are taken.
class Attacker {
 public:
  explicit Attacker(const std::string& url) : url_(url), lcm_(url) {}

  void Send(const std::string& channel, const Bytes& bytes) {
    constexpr int kInFlight = 20;  // fit into the smallest buffer that a kernel gives
    REQUIRE(lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size())) == 0);
    if (++num_sent_ % kInFlight == 0) Settle();
  }
  void Settle() {
    REQUIRE(WaitUntil([this] { return KernelIsEmpty(url_); }, std::chrono::microseconds(100)));
  }

 private:
  std::string url_;
  lcm::LCM lcm_;
  int num_sent_ = 0;
};

/// The count of a service, when it has reached `least` or is late.
std::int64_t AwaitCount(TestBus& bus, const std::string& service, const std::string& counter, std::int64_t least) {
  const std::string name = service + "." + counter;
  bus.Await([&] { return bus.Count(name) >= least; });
  return bus.Count(name);
}

const std::map<std::string, std::vector<std::string>> kListensTo{
    {"laser_publisher", {kMapDeltaChannel, kScanAnswerChannel}},
    {"ray_selector", {kLaserChannel}},
    {"rrhc_matcher", {kOdometryChannel, kCriticalRaysChannel, kMapDeltaChannel, kMapPageChannel, kScanAnswerChannel}},
    {"map_updater",
     {kCriticalRaysChannel, kScanMatchChannel, kMapRequestChannel, kScanRequestChannel, kPoseGraphChannel,
      kKeyframeRequestChannel}},
    {"loop_closer", {kKeyframeChannel}},
    {"map_exporter", {kCriticalRaysChannel, kWholeMapChannel, kStatusOfSomebody}}};

/// On these channels a process believes one sender, and does not even read what others send.
const std::set<std::string> kOfOneSender{kCriticalRaysChannel, kScanMatchChannel,  kMapDeltaChannel, kMapPageChannel,
                                         kWholeMapChannel,     kScanAnswerChannel, kKeyframeChannel, kPoseGraphChannel};

std::string CounterOf(const std::string& channel) {
  return channel.substr(0, channel.find('/')) + (kOfOneSender.count(channel) ? "_refused" : "_malformed");
}

/// What memory may grow by between 1,000 messages on each channel and 10,000: the allocator's slack, in which one kept
/// block of a hundred bytes a message, 0.9 MB, would not hide. The sanitizers keep freed blocks for a while.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double kSlackMb = 8.0;
#else
constexpr double kSlackMb = 0.6;
#endif

}  // namespace

TEST_CASE("malformed messages are counted one by one, take no memory and stop nobody") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 3), "run.lcm");
  const std::string url = MakeBusUrl();
  MapWatcher map(url);
  TestBus bus(url);
  Stack stack({url, folder / "out", {}, false});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.Start("loop_closer"));
  REQUIRE(stack.StartPublisher(log, "0.0001"));  // after the first scan it waits for hours
  REQUIRE(map.AwaitVersion(1));

  Attacker attacker(url);
  std::vector<Channel> channels = MakeChannels();
  std::map<std::string, double> resident_mb;
  for (int batch = 1; batch <= 10; ++batch) {
    for (Channel& channel : channels) {
      for (int i = 0; i < 1000; ++i) {
        attacker.Send(channel.name, channel.malformed[channel.num_sent++ % channel.malformed.size()]);
      }
    }
    for (const auto& [service, listens_to] : kListensTo) {
      for (const Channel& channel : channels) {
        if (std::count(listens_to.begin(), listens_to.end(), channel.name) == 0) continue;
        INFO(service << " on " << channel.name);
        REQUIRE(AwaitCount(bus, service, CounterOf(channel.name), channel.num_sent) == channel.num_sent);
      }
      if (batch == 1) resident_mb[service] = stack[service].ResidentMb();
    }
  }
  for (const auto& [service, after_1000_mb] : resident_mb) {
    INFO(service << ": " << after_1000_mb << " MB after 1,000, " << stack[service].ResidentMb() << " MB after 10,000");
    CHECK(stack[service].ResidentMb() < after_1000_mb + kSlackMb);
  }

  attacker.Send(kLaserChannel, Encode(MakeLaser(1'000'000)));
  attacker.Settle();
  MapWatcher fresh(url);  // the queue of the other is full of malformed messages
  stack["laser_publisher"].Signal(SIGINT);
  CHECK(stack["laser_publisher"].AwaitExit() == 0);
  for (int i = 0; i < 14; ++i) {  // some seconds after the publisher has gone, another sender is believed
    attacker.Send(kLaserChannel, Encode(MakeLaser()));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  CHECK(fresh.AwaitScan(kUtime));
  CHECK(stack.Finish());
  CHECK(CountLines(ReadFile(folder / "out/trajectory.tum")) == 2);
}

TEST_CASE("well-formed messages that mean nothing do not change the map of a run in lockstep") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 200, 2);
  const std::string log = folder.Write(scans, "run.lcm");
  folder.Map(log, "offline");
  const std::string url = MakeBusUrl();
  MapWatcher map(url);
  Stack stack({url, folder / "out", {}});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(log, "max"));
  REQUIRE(map.AwaitVersion(2));

  scan_request_t request = ScanRequestMessage();
  request.utime = scans[0].utime;
  critical_rays_t rays = CriticalRaysMessage();
  rays.utime = scans[0].utime;
  const std::vector<std::pair<const char*, Bytes>> nonsense{
      {kMapRequestChannel, Encode(map_request_t{.requester = 42, .base_version = kFar})},
      {kMapRequestChannel, Encode(map_request_t{.requester = 42, .first_tile = kMost})},
      {kMapRequestChannel, Encode(map_request_t{.requester = 42, .first_match = kMost})},
      {kMapRequestChannel, Encode(map_request_t{.requester = 42, .epoch = kFar})},
      {kMapDeltaChannel, Encode(MakeDelta(7, kFar))},
      {kMapDeltaChannel, Encode(MakeDelta(-1, 1))},
      {kMapPageChannel, Encode(MapPageMessage())},
      {kScanAnswerChannel, Encode(ScanAnswerMessage())},
      {kScanRequestChannel, Encode(request)},
      {kScanMatchChannel, Encode(scan_match_t{.utime = 123, .fitness = 0.5, .state = scan_match_t::OK})},
      {kScanMatchChannel, Encode(scan_match_t{.utime = scans[0].utime, .fitness = 0.5, .state = scan_match_t::OK})},
      {kCriticalRaysChannel, Encode(rays)},
      {kStatusOfSomebody, Encode(StatusOf("\xff\xfe"))}};
  Attacker attacker(url);
  for (std::size_t i = 0; stack["laser_publisher"].IsRunning(); ++i) {
    attacker.Send(nonsense[i % nonsense.size()].first, nonsense[i % nonsense.size()].second);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  CHECK(stack.Finish());
  folder.CheckSame("out", "offline");
}

TEST_CASE("an exporter that hears of thousands of services remembers a few of them") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  Process exporter("map_exporter", {"--lcm-url", url, "--out", folder / "out"}, folder / "log");
  REQUIRE(exporter.AwaitReady());
  Attacker attacker(url);
  double after_1000_mb = 0.0;
  for (int i = 1; i <= 3000; ++i) {
    attacker.Send(kStatusOfSomebody, Encode(StatusOf(std::to_string(i))));
    if (i % 1000 != 0) continue;
    REQUIRE(AwaitCount(bus, "map_exporter", "status_ignored", i - 64) > 0);
    if (i == 1000) after_1000_mb = exporter.ResidentMb();
  }
  CHECK(exporter.ResidentMb() < after_1000_mb + kSlackMb);
  CHECK(exporter.Interrupt() == 0);
}
