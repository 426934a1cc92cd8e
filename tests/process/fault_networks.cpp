// Several hosts, which are network namespaces; packets that are lost, and those of attackers.

#include <sched.h>

#include <atomic>
#include <thread>

#include "catch.hpp"
#include "faults.hpp"
#include "packets.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kFiles{"map.png", "trajectory.tum"};

/// Publisher, matcher, and all others on three hosts, in lockstep; or all on one.
void MapOnHosts(const TemporaryFolder& folder, const Hosts& hosts, bool on_three, const FaultCourse& course,
                const std::vector<std::string>& updater_flags = {}) {
  fs::remove_all(folder / "out");
  const int sensor = hosts[0].network();
  const int computer = hosts[on_three ? 1 : 0].network();
  const int rest = hosts[on_three ? 2 : 0].network();
  Stack stack({.url = MakeBusUrl(1),
               .out = folder / "out",
               .flags = course.flags,
               .own_flags = {{"map_updater", updater_flags}},
               .networks = {{"laser_publisher", sensor},
                            {"rrhc_matcher", computer},
                            {"map_updater", rest},
                            {"loop_closer", rest},
                            {"ray_selector", rest},
                            {"map_exporter", rest}}});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(course.log, "max"));
  CHECK(stack.Finish());
  folder.CheckSame("out", course.name, kFiles);
}

/// Courses, or the first scans of each, on a network that loses some of its packets.
void MapOnNetworks(Courses which, std::size_t num_most, const std::vector<double>& shares) {
  if (!MayMakeHosts(shares.back() > 0.0)) return;
  const TemporaryFolder folder;
  for (FaultCourse course : WriteCourses(folder, which)) {
    course.log = folder.Write(TakeScans(course.log, num_most), "beginning.lcm");
    folder.MapWithStack(course.log, course.name, course.flags);
    for (const double share : shares) {
      const Hosts hosts(folder, 3, share);
      MapOnHosts(folder, hosts, false, course);
      MapOnHosts(folder, hosts, true, course);
      MapOnHosts(folder, hosts, true, course, {"--part-bytes", "1400"});
      const std::int64_t num_lost = share == 0.0 ? 0 : hosts.CountLost();
      CHECK((num_lost > 0 || share == 0.0));
      fmt::print("{}, {:.0f} % lost: same map on one host and on three; {} packets lost\n", course.name, 100.0 * share,
                 num_lost);
    }
  }
}

}  // namespace

TEST_CASE("hosts", "[.][fault][hosts]") { MapOnNetworks(Courses::kPlain, 1'000'000, {0.0}); }

TEST_CASE("loss", "[.][fault][loss]") { MapOnNetworks(Courses::kAll, ByEffort(150, 1500), {0.01, 0.05}); }

TEST_CASE("attackers", "[.][fault][attackers]") {
  if (!MayMakeHosts()) return;
  constexpr int kCount = 1000;
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 1'000'000);
  const std::size_t num_scans = ByEffort(3000, 6000);  // longer than all the packets take
  const std::string log = WriteToAndFro(folder, scans, num_scans);
  folder.Map(log, "undisturbed");
  struct Attack {
    const char* name;
    int bus_ttl;
    std::size_t from;  ///< host; the stack is on the first
    unsigned char ttl;
    bool with_scans;
  };
  for (const Attack& attack : {Attack{"the same host, ttl=0", 0, 0, 0, false},
                               {"the same host, ttl=1", 0, 0, 1, false},
                               {"another host, a bus of ttl=0", 0, 1, 1, true},
                               {"another host, a bus of ttl=1", 1, 1, 1, false}}) {
    INFO(attack.name);
    const Hosts hosts(folder, 2);
    const std::string url = MakeBusUrl(attack.bus_ttl);
    fs::remove_all(folder / "attacked");
    Process stack = folder.StartStack(log, "attacked", url, {}, hosts[0].network());
    REQUIRE(WaitUntil([&] { return JournalBytes(folder / "attacked") > 100'000; }));
    std::atomic<int> num_sent = 0;
    std::jthread attacker([&](const std::stop_token& stop) {
      if (setns(hosts[attack.from].network(), CLONE_NEWNET) != 0) return;
      const RawSender sender(attack.ttl);
      for (std::uint32_t i = 0; i < kCount; ++i) {
        for (const char* channel : {"LASER", "SCAN_MATCH", "MAP_DELTA"}) {
          SendWrappingFragments(sender, PortOf(url), channel, i);
        }
        ++num_sent;
        std::this_thread::sleep_for(std::chrono::microseconds(500));
      }
      lcm::LCM lcm("udpm://239.255.76.67:" + std::to_string(PortOf(url)) + "?ttl=1");
      for (std::size_t i = 0; attack.with_scans && !stop.stop_requested(); ++i) {
        LaserScan scan = scans[i % scans.size()];
        scan.utime = 1'000'000'000'000'000 + static_cast<std::int64_t>(i);
        const bot_core::planar_lidar_t message = ToMessage(scan);
        lcm.publish(kLaserChannel, &message);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
    });
    CHECK(stack.AwaitExit(kLongRun) == 0);
    CHECK(num_sent == kCount);
    INFO(stack.errors());
    CHECK(stack.errors().find("ended unexpectedly") == std::string::npos);
    folder.CheckSame("attacked", "undisturbed", kFiles);
    CHECK(folder.Summary("attacked")["counts"]["ray_selector.handled"] == num_scans);
    fmt::print("{}: same map\n", attack.name);
  }
}
