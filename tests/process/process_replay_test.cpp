// One process alone, with the test in place of the owner of its map.

#include <limits>

#include "catch.hpp"
#include "common/scan/ray_selector.hpp"
#include "map_owner.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

TEST_CASE("a matcher goes on where the owner has lost its last match again, and the publisher has gone on") {
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 3, 10);
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Process matcher("rrhc_matcher", {"--lcm-url", url, "--lockstep", "--no-odometry"}, folder / "log");
  REQUIRE(matcher.AwaitReady());
  TestBus bus(url);
  MapOwner owner(Parameters().update);
  owner.Serve(*bus);
  std::vector<scan_match_t> answers;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t& answer) { answers.push_back(answer); });
  REQUIRE(bus.Await([&] { return owner.num_pages > 0; }));
  RaySelector selector({});
  for (const LaserScan& scan : scans) {  // which the owner has taken, and has forgotten by now
    const critical_rays_t rays = ToMessage(selector.Select(scan));
    REQUIRE(bus.Await([&] {
      bus->Publish(kCriticalRaysChannel, rays);
      return !answers.empty() && answers.back().utime == scan.utime;
    }));
  }
  CHECK(matcher.Interrupt() == 0);
  CHECK(matcher.errors().find("has lost scan") != std::string::npos);
}

TEST_CASE(
    "laser_publisher at rate max sends a scan again until its map has come, and all scans in the source's order") {
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 20, 10);
  const TemporaryFolder folder;
  const std::string log = folder.Write(scans, "run.lcm");
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  std::vector<bot_core::planar_lidar_t> sent;
  bus->Subscribe<bot_core::planar_lidar_t>(kLaserChannel,
                                           [&](const bot_core::planar_lidar_t& message) { sent.push_back(message); });
  Process publisher("laser_publisher", {log, "--lcm-url", url, "--rate", "max", "--resend-s", "0.05"}, folder / "log");
  constexpr std::int64_t kNoLater = std::numeric_limits<std::int64_t>::max();
  for (std::size_t i = 0; i < scans.size(); ++i) {
    // No map comes for the fourth scan, so that it is sent three times.
    // The first may be sent again before it is believed who owns the map.
    const auto DropFormer = [&] {
      std::erase_if(sent, [&](const auto& message) { return i > 0 && message.utime == scans[i - 1].utime; });
    };
    REQUIRE(bus.Await([&] { return DropFormer(), sent.size() >= (i == 3 ? 3 : 1); }));
    for (const auto& message : sent) CHECK(Encode(message) == Encode(ToMessage(scans[i])));
    sent.clear();
    if (i % 2 == 1) {                                     // it is in the map already
      const scan_match_t match{.utime = scans[i].utime};  // which neither of these says to the publisher
      for (const scan_answer_t& other : {scan_answer_t{scans[i].utime, 1, 0, kNoLater, 0, {}},
                                         scan_answer_t{scans[i].utime, 1, 77, kNoLater, 1, {match}}}) {
        bus->Publish(kScanAnswerChannel, other);
        REQUIRE(bus.Await([&] { return !sent.empty(); }));
        CHECK(sent.back().utime == scans[i].utime);
        sent.clear();
      }
      bus->Publish(kScanAnswerChannel, scan_answer_t{scans[i].utime, 1, 0, kNoLater, 1, {match}});
      continue;
    }
    const map_delta_t delta{.utime = scans[i].utime,
                            .epoch = 1,
                            .version = static_cast<std::int64_t>(i) + 1,
                            .cell_size_m = 0.05,
                            .num_parts = 1};
    bus->Publish(kMapDeltaChannel, delta);
  }
  CHECK(publisher.AwaitExit() == 0);
}
