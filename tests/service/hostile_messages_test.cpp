// Messages that no honest sender sends. Every process reads them, none believes them.

#include <algorithm>
#include <csignal>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <thread>

#include "catch.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/graph_messages.hpp"

using namespace crsm;

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::int64_t kFar = std::int64_t{1} << 62;
constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kUtime = 5'000'000;

bot_core::planar_lidar_t MakeLaser(int num_beams = 40) {
  LaserScan scan{kUtime, -1.5f, 3.0f / static_cast<float>(num_beams), {}};
  for (int i = 0; i < num_beams; ++i) scan.ranges_m.push_back(3.0f + 0.01f * static_cast<float>(i % 100));
  return ToMessage(scan);
}

critical_rays_t MakeRays() {
  critical_rays_t rays{};
  rays.utime = kUtime;
  rays.num_rays = 4;
  rays.angle_rad = {-1.0f, -0.5f, 0.5f, 1.0f};
  rays.range_m = {2.0f, 2.0f, 3.0f, 3.0f};
  rays.num_critical = 2;
  rays.critical = {0, 3};
  return rays;
}

scan_match_t MakeMatch() {
  scan_match_t match{};
  match.utime = kUtime;
  match.fitness = 0.5;
  match.state = scan_match_t::OK;
  return match;
}

map_delta_t MakeDelta() {
  map_delta_t delta{};
  delta.utime = kUtime;
  delta.epoch = 7;
  delta.version = 1;
  delta.cell_size_m = 0.05;
  delta.num_parts = 1;
  delta.num_tiles = 1;
  delta.tiles = {{0, 0, 7, {0, 0, 0, 3, 255, 255, 0}}};
  delta.num_matches = 1;
  delta.matches = {MakeMatch()};
  return delta;
}

map_request_t MakeRequest() {
  map_request_t request{};
  request.requester = 42;
  return request;
}

constexpr const char* kStatusOfSomebody = "SERVICE_STATUS/somebody";

service_status_t MakeStatus() {
  service_status_t status{};
  status.name = "somebody";
  status.version = "1";
  status.state = "at rest";
  status.num_counters = 1;
  status.counter_name = {"handled"};
  status.counter_value = {3};
  return status;
}

/// A well-formed message with one field changed: encoded as it is, so counts are not to be changed here.
template <class Message, class Change>
Bytes Changed(Message message, Change change) {
  change(message);
  return Encode(message);
}

void PutInt32(Bytes& bytes, std::size_t at, std::int64_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes.at(at + i) = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

/// What goes wrong with any type: nothing there, cut short, too long, another type, counts that are none.
std::vector<Bytes> Damage(const Bytes& good, const std::vector<std::size_t>& counts_at) {
  std::vector<Bytes> damaged;
  for (std::size_t size = 0; size < good.size(); ++size) {
    damaged.emplace_back(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
  }
  damaged.push_back(good);
  damaged.back().push_back(0);
  for (const std::uint8_t byte : {std::uint8_t{0x00}, std::uint8_t{0xff}}) {
    damaged.push_back(good);
    std::fill_n(damaged.back().begin(), 8, byte);
  }
  damaged.push_back(good);
  damaged.back()[7] = static_cast<std::uint8_t>(good[7] ^ 1);
  for (const std::size_t at : counts_at) {
    for (const std::int64_t count : {std::int64_t{-1}, std::int64_t{1'000'000}, std::int64_t{1} << 30,
                                     (std::int64_t{1} << 31) - 1, -(std::int64_t{1} << 31)}) {
      damaged.push_back(good);
      PutInt32(damaged.back(), at, count);
    }
  }
  return damaged;
}

/// A channel and all that is wrong on it.
struct Channel {
  const char* name;
  std::vector<Bytes> malformed;
  std::int64_t num_sent = 0;
};

void Append(std::vector<Bytes>& all, std::vector<Bytes> more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

void AppendThoseOfLoops(std::vector<Channel>& channels) {
  const keyframe_t keyframe =
      ToMessage(Keyframe{kUtime, {{-1.0f, 1.0f}, {2.0f, 3.0f}}, {}}, {7, {0, 3}, KeyframeId{0, 2}});
  channels.push_back({kKeyframeChannel, Damage(Encode(keyframe), {8 + 8 + 8 + 3 * 8})});
  Append(channels.back().malformed,
         {Changed(keyframe, [](auto& k) { k.epoch = 0; }),
          Changed(keyframe,
                  [](auto& k) {
                    k.id = {0, -1};
                  }),
          Changed(keyframe,
                  [](auto& k) {
                    k.previous = {0, 1};
                  }),
          Changed(keyframe, [](auto& k) { k.range_m[0] = kNan; }),
          Changed(keyframe, [](auto& k) { k.T_previous_this.x_m = kInfinity; }),
          Changed(keyframe, [](auto& k) { k.num_open_axes = 1; }), Changed(keyframe, [](auto& k) {
            k.num_ties = 1, k.tied_to = {0, 3};
          })});
  const keyframe_request_t request{7, {-1, -1}, 20};
  channels.push_back({kKeyframeRequestChannel, Damage(Encode(request), {})});
  Append(channels.back().malformed, {Changed(request, [](auto& r) { r.epoch = 0; }),
                                     Changed(request,
                                             [](auto& r) {
                                               r.after = {0, -1};
                                             }),
                                     Changed(request, [](auto& r) { r.num_keyframes = 0; }),
                                     Changed(request, [](auto& r) { r.num_keyframes = kMost; })});
  GraphUpdate update;
  update.closed = {{{0, 0}, {0, 1}, {}}};
  update.keyframe = {0, 1};
  update.moved = {{{0, 0}, std::vector<Pose2>(2)}};
  const pose_graph_t graph = MakeParts(update, kUtime, 7).front();
  constexpr std::size_t kNumClosedAt = 8 + 8 + 8 + 2 * 8 + 1 + 4 + 4 + 8;
  constexpr std::size_t kNumTakenOutAt = kNumClosedAt + 4 + 2 * 8 + 24;
  constexpr std::size_t kNumMovedAt = kNumTakenOutAt + 4;
  channels.push_back(
      {kPoseGraphChannel, Damage(Encode(graph), {kNumClosedAt, kNumTakenOutAt, kNumMovedAt, kNumMovedAt + 4 + 8})});
  Append(channels.back().malformed, {Changed(graph, [](auto& g) { g.epoch = 0; }),
                                     Changed(graph,
                                             [](auto& g) {
                                               g.previous = {0, 1};
                                             }),
                                     Changed(graph, [](auto& g) { g.num_parts = 0; }),
                                     Changed(graph,
                                             [](auto& g) {
                                               g.closed[0].newer = {0, 0};
                                             }),
                                     Changed(graph, [](auto& g) { g.moved[0].first.number = kMost; }),
                                     Changed(graph, [](auto& g) { g.moved[0].poses[1].yaw_rad = kNan; })});
}

std::vector<Channel> MakeChannels() {
  // Where the counts stand: behind the fingerprint of 8 bytes and the fields before them, see lcmtypes/.
  std::vector<Channel> channels;
  channels.push_back({kLaserChannel, Damage(Encode(MakeLaser()), {16, 20 + 40 * 4})});
  for (const int num_beams : {0, 1, 4097}) channels.back().malformed.push_back(Encode(MakeLaser(num_beams)));
  for (const float angle : {kNan, kInfinity, -kInfinity, 7.0f}) {
    Append(channels.back().malformed, {Changed(MakeLaser(), [&](auto& laser) { laser.rad0 = angle; }),
                                       Changed(MakeLaser(), [&](auto& laser) { laser.radstep = angle; })});
  }
  channels.back().malformed.push_back(Changed(MakeLaser(), [](auto& laser) { laser.radstep = 0.0f; }));
  channels.back().malformed.push_back(Changed(MakeLaser(), [](auto& laser) { laser.utime = -1; }));

  const bot_core::pose_t odometry = ToPoseMessage(kUtime, {});
  channels.push_back({kOdometryChannel, Damage(Encode(odometry), {})});
  for (const double value : {double{kNan}, double{kInfinity}, double{-kInfinity}, 1e30}) {
    Append(channels.back().malformed, {Changed(odometry, [&](auto& pose) { pose.pos[0] = value; }),
                                       Changed(odometry, [&](auto& pose) { pose.pos[2] = value; }),
                                       Changed(odometry, [&](auto& pose) { pose.orientation[0] = value; }),
                                       Changed(odometry, [&](auto& pose) { pose.orientation[3] = value; })});
  }
  channels.back().malformed.push_back(Changed(odometry, [](auto& pose) { pose.utime = -1; }));
  channels.push_back({kCriticalRaysChannel, Damage(Encode(MakeRays()), {16, 20 + 4 * 8})});
  for (const float value : {kNan, kInfinity, -kInfinity, -1.0f}) {
    Append(channels.back().malformed, {Changed(MakeRays(), [&](auto& rays) { rays.range_m[1] = value; })});
  }
  Append(channels.back().malformed, {Changed(MakeRays(), [](auto& rays) { rays.angle_rad[1] = kNan; }),
                                     Changed(MakeRays(), [](auto& rays) { rays.angle_rad[1] = 0.7f; }),
                                     Changed(MakeRays(), [](auto& rays) { rays.angle_rad[3] = 1e9f; }),
                                     Changed(MakeRays(),
                                             [](auto& rays) {
                                               rays.critical = {0, 4};
                                             }),
                                     Changed(MakeRays(),
                                             [](auto& rays) {
                                               rays.critical = {-1, 1};
                                             }),
                                     Changed(MakeRays(), [](auto& rays) {
                                       rays.critical = {2, 2};
                                     })});

  const auto DamageMatch = [](auto&& Put) {
    std::vector<Bytes> damaged;
    for (const double value : {double{kNan}, double{kInfinity}, double{-kInfinity}, 1e30}) {
      damaged.push_back(Put([&](scan_match_t& match) { match.x_m = value; }));
      damaged.push_back(Put([&](scan_match_t& match) { match.y_m = value; }));
      damaged.push_back(Put([&](scan_match_t& match) { match.yaw_rad = value; }));
      damaged.push_back(Put([&](scan_match_t& match) { match.fitness = value; }));
    }
    damaged.push_back(Put([](scan_match_t& match) { match.utime = -1; }));
    damaged.push_back(Put([](scan_match_t& match) { match.state = 4; }));
    damaged.push_back(Put([](scan_match_t& match) { match.state = -1; }));
    damaged.push_back(Put([](scan_match_t& match) { match.num_critical = 1'000'000; }));
    damaged.push_back(Put([](scan_match_t& match) { match.map_version = -1; }));
    return damaged;
  };
  channels.push_back({kScanMatchChannel, Damage(Encode(MakeMatch()), {})});
  Append(channels.back().malformed, DamageMatch([](auto change) { return Changed(MakeMatch(), change); }));

  // Behind the matches stand three more counts.
  const std::size_t match_bytes = Encode(MakeMatch()).size() - 8;
  const std::size_t num_matches_at = Encode(MakeDelta()).size() - 4 - 4 - 4 - 4 - match_bytes;
  const std::size_t behind_at = num_matches_at + 4 + match_bytes;
  channels.push_back({kMapDeltaChannel, Damage(Encode(MakeDelta()),
                                               {56, 68, 76, num_matches_at, behind_at, behind_at + 4, behind_at + 8})});
  Append(channels.back().malformed,
         DamageMatch([](auto change) { return Changed(MakeDelta(), [&](auto& delta) { change(delta.matches[0]); }); }));
  Append(channels.back().malformed,
         {Changed(MakeDelta(), [](auto& delta) { delta.cell_size_m = kNan; }),
          Changed(MakeDelta(), [](auto& delta) { delta.cell_size_m = 0.0; }),
          Changed(MakeDelta(), [](auto& delta) { delta.epoch = 0; }),
          Changed(MakeDelta(), [](auto& delta) { delta.num_parts = 0; }),
          Changed(MakeDelta(), [](auto& delta) { delta.num_parts = 1'000'000; }),
          Changed(MakeDelta(), [](auto& delta) { delta.part = 1; }),
          Changed(MakeDelta(), [](auto& delta) { delta.part = -1; }),
          Changed(MakeDelta(), [](auto& delta) { delta.next_tile = -2; }),
          Changed(MakeDelta(), [](auto& delta) { delta.next_match = -2; }),
          Changed(MakeDelta(), [](auto& delta) { delta.num_requests = 1, delta.request = {map_request_t{}}; }),
          Changed(MakeDelta(), [](auto& delta) { delta.base_version = 2; }),
          Changed(MakeDelta(), [](auto& delta) { delta.tiles[0].tile_x = 2000; })});
  channels.push_back({kWholeMapChannel, channels.back().malformed});

  channels.push_back({kMapRequestChannel, Damage(Encode(MakeRequest()), {})});
  Append(channels.back().malformed, {Changed(MakeRequest(), [](auto& request) { request.requester = 0; }),
                                     Changed(MakeRequest(), [](auto& request) { request.base_version = -1; }),
                                     Changed(MakeRequest(), [](auto& request) { request.first_tile = -1; }),
                                     Changed(MakeRequest(), [](auto& request) { request.first_match = -2; }),
                                     Changed(MakeRequest(), [](auto& request) { request.asked_utime = -2; }),
                                     Changed(MakeRequest(), [](auto& request) { request.whole = 2; }),
                                     Changed(MakeRequest(), [](auto& request) { request.settled = -1; })});
  AppendThoseOfLoops(channels);

  // The lengths of the name, the version and the state, and the number of counters.
  channels.push_back({kStatusOfSomebody, Damage(Encode(MakeStatus()), {16, 29, 39, 51})});
  Append(channels.back().malformed, {Changed(MakeStatus(), [](auto& status) { status.latency_p50_ms = kNan; }),
                                     Changed(MakeStatus(), [](auto& status) { status.latency_max_ms = kInfinity; }),
                                     Changed(MakeStatus(), [](auto& status) { status.resident_mb = -1.0; })});
  return channels;
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

/// What the services count, as they tell it once a second.
class StatusWatcher {
 public:
  explicit StatusWatcher(const std::string& url) : bus_(url) {
    bus_->Subscribe<service_status_t>(kEveryServiceStatus, [this](const service_status_t& status) {
      for (std::size_t i = 0; i < status.counter_name.size(); ++i) {
        counts_[status.name + "." + status.counter_name[i]] = status.counter_value[i];
      }
    });
  }

  /// The count, when it has reached `least` or is late.
  std::int64_t Await(const std::string& service, const std::string& counter, std::int64_t least) {
    std::int64_t& count = counts_[service + "." + counter];
    bus_.Await([&] { return count >= least; });
    return count;
  }

 private:
  TestBus bus_;
  std::map<std::string, std::int64_t> counts_;
};

const std::map<std::string, std::vector<std::string>> kListensTo{
    {"laser_publisher", {kMapDeltaChannel}},
    {"ray_selector", {kLaserChannel}},
    {"rrhc_matcher", {kOdometryChannel, kCriticalRaysChannel, kMapDeltaChannel}},
    {"map_updater",
     {kCriticalRaysChannel, kScanMatchChannel, kMapRequestChannel, kPoseGraphChannel, kKeyframeRequestChannel}},
    {"loop_closer", {kKeyframeChannel}},
    {"map_exporter", {kCriticalRaysChannel, kWholeMapChannel, kStatusOfSomebody}}};

/// On these channels a process believes one sender, and does not even read what others send.
const std::set<std::string> kOfOneSender{kCriticalRaysChannel, kScanMatchChannel, kMapDeltaChannel,
                                         kWholeMapChannel,     kKeyframeChannel,  kPoseGraphChannel};

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
  WriteScans(TakeScans("sim:demo", 3), folder / "run.lcm");
  const std::string url = MakeBusUrl();
  MapWatcher map(url);
  StatusWatcher statuses(url);
  std::ofstream(folder / "all.toml") << "odometry = true\n";
  Stack stack({url, folder / "out", {"--config", folder / "all.toml"}, false});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.Start("loop_closer"));
  REQUIRE(stack.StartPublisher(folder / "run.lcm", "0.0001"));  // after the first scan it waits for hours
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
        REQUIRE(statuses.Await(service, CounterOf(channel.name), channel.num_sent) == channel.num_sent);
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
  attacker.Send(kLaserChannel, Encode(MakeLaser()));
  CHECK(fresh.AwaitScan(kUtime));
  stack["laser_publisher"].Signal(SIGINT);
  CHECK(stack.Finish());
  const std::string trajectory = ReadFile(folder / "out/trajectory.tum");
  CHECK(std::count(trajectory.begin(), trajectory.end(), '\n') == 2);
}

TEST_CASE("well-formed messages that mean nothing do not change the map of a run in lockstep") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 200, 2);
  WriteScans(scans, folder / "run.lcm");
  REQUIRE(Run("slam_offline", {folder / "run.lcm", "--out", folder / "offline"}, folder / "log") == 0);
  const std::string url = MakeBusUrl();
  MapWatcher map(url);
  Stack stack({url, folder / "out", {}});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(folder / "run.lcm", "max"));
  REQUIRE(map.AwaitVersion(2));

  const std::vector<std::pair<const char*, Bytes>> nonsense{
      {kMapRequestChannel, Changed(MakeRequest(), [](auto& request) { request.base_version = kFar; })},
      {kMapRequestChannel, Changed(MakeRequest(), [](auto& request) { request.first_tile = kMost; })},
      {kMapRequestChannel, Changed(MakeRequest(), [](auto& request) { request.first_match = kMost; })},
      {kMapDeltaChannel, Changed(MakeDelta(), [](auto& delta) { delta.version = kFar; })},
      {kMapDeltaChannel, Changed(MakeDelta(), [](auto& delta) { delta.version = delta.base_version = kFar; })},
      {kMapDeltaChannel,
       Changed(MakeDelta(), [](auto& delta) { delta.num_requests = 1, delta.request = {MakeRequest()}; })},
      {kMapDeltaChannel, Changed(MakeDelta(), [](auto& delta) { delta.epoch = -1; })},
      {kMapRequestChannel, Changed(MakeRequest(), [](auto& request) { request.epoch = kFar; })},
      {kScanMatchChannel, Changed(MakeMatch(), [](auto& match) { match.utime = 123; })},
      {kScanMatchChannel, Changed(MakeMatch(), [&](auto& match) { match.utime = scans[0].utime; })},
      {kCriticalRaysChannel, Changed(MakeRays(), [&](auto& rays) { rays.utime = scans[0].utime; })},
      {kStatusOfSomebody, Changed(MakeStatus(), [](auto& status) { status.name = "\xff\xfe"; })}};
  Attacker attacker(url);
  for (std::size_t i = 0; stack["laser_publisher"].IsRunning(); ++i) {
    attacker.Send(nonsense[i % nonsense.size()].first, nonsense[i % nonsense.size()].second);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  CHECK(stack.Finish());
  for (const char* file : {"map.png", "trajectory.tum"}) {
    INFO(file);
    CHECK(ReadFile(folder / "out" / file) == ReadFile(folder / "offline" / file));
  }
}

TEST_CASE("an exporter that hears of thousands of services remembers a few of them") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  StatusWatcher statuses(url);
  Process exporter("map_exporter", {"--lcm-url", url, "--out", folder / "out"}, folder / "log");
  REQUIRE(exporter.AwaitReady());
  Attacker attacker(url);
  double after_1000_mb = 0.0;
  for (int i = 1; i <= 3000; ++i) {
    attacker.Send(kStatusOfSomebody, Changed(MakeStatus(), [&](auto& status) { status.name = std::to_string(i); }));
    if (i % 1000 != 0) continue;
    REQUIRE(statuses.Await("map_exporter", "status_ignored", i - 64) > 0);
    if (i == 1000) after_1000_mb = exporter.ResidentMb();
  }
  CHECK(exporter.ResidentMb() < after_1000_mb + kSlackMb);
  CHECK(exporter.Interrupt() == 0);
}
