// map_viewer beside a stack: what its page is told is the map, whoever comes late, is cut off or killed.

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <thread>
#include <utility>

#include "catch.hpp"
#include "map_owner.hpp"
#include "services/replica/map_replica.hpp"
#include "services/wire/conversions.hpp"
#include "viewer_page.hpp"

using namespace crsm;

namespace {

using Clock = std::chrono::steady_clock;

critical_rays_t ScanOf(std::int64_t utime) {
  return {utime, 3, {-0.5f, 0.0f, 0.5f}, {1.0f, 2.0f, 3.0f}, 2, {0, 2}, 0, {}};
}

/// What the owner of the map says that all of it is.
std::map<TileIndex, TileBytes> AskOwner(const std::string& url) {
  TestBus bus(url);
  ByteMap map(1.0);
  MapReplica replica(4711,
                     {[&](double cell_size_m) { map = ByteMap(cell_size_m); },
                      [&](std::span<const TileChange> changes) {
                        for (const TileChange& change : changes) map.Apply(change);
                      }},
                     MapReplica::View::kWhole);
  bus->Subscribe<map_page_t>(kWholeMapChannel, [&](const map_page_t& page) { replica.Handle(page); });
  auto next = Clock::now();
  REQUIRE(bus.Await([&] {
    auto request = replica.NextRequest();
    if (request && Clock::now() >= next) {
      next = Clock::now() + std::chrono::milliseconds(20);
      bus->Publish(kMapRequestChannel, *request);
    }
    return replica.synced();
  }));
  std::map<TileIndex, TileBytes> tiles;
  for (const auto& entry : map.tiles().entries()) tiles[entry.index] = entry.tile->cells;
  std::erase_if(tiles, [](const auto& tile) { return tile.second == ByteMap::Tile().cells; });
  return tiles;
}

/// A viewer on a bus of its own, and its page.
struct ViewerOnBus {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Viewer viewer{{"--lcm-url", url}, folder};
  Page page{AwaitPort(viewer)};
  TestBus bus{url};

  /// Takes what the page is told, and hears the bus, until `condition` holds. False if it does not in time.
  template <class Condition>
  bool Await(const Condition& condition) {
    return page.Await([&] {
      bus->Wait(1);
      return condition();
    });
  }

 private:
  static std::uint16_t AwaitPort(Viewer& viewer) {
    REQUIRE(viewer.AwaitReady());
    return viewer.port();
  }
};

}  // namespace

TEST_CASE("the page of a viewer has the owner's map, the robot's scans, its path, the services and their counters",
          "[viewer]") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Stack stack({url, folder / "out", {}});
  REQUIRE(stack.StartServices());
  Viewer viewer({"--lcm-url", url}, folder);
  REQUIRE(viewer.AwaitReady());
  Page page(viewer.port());
  TestBus bus(url);
  int num_drawn = 0;
  bus->Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t&) { ++num_drawn; });
  REQUIRE(stack.StartPublisher("sim:demo", "max"));
  REQUIRE(bus.Await([&] { return num_drawn > 20; }));
  stack["laser_publisher"].Signal(SIGSTOP);  // until the page has some of the map: the rest it sees as changes
  REQUIRE(page.Await([&] { return page->complete && page->version > 0; }));
  stack["laser_publisher"].Signal(SIGCONT);
  const auto scans = static_cast<std::int64_t>(TakeScans("sim:demo", 100000).size());
  REQUIRE(page.Await([&] { return page->complete && page->version == scans; }));
  REQUIRE(stack["laser_publisher"].AwaitExit() == 0);
  CHECK(page->ExploredTiles() == AskOwner(url));
  CHECK(page->num_begun == 1);
  CHECK(page->num_changed_tiles > 0);
  CHECK(page->num_robots > 5);
  CHECK(page->num_rays > 100);
  CHECK(page->path.size() > 100);
  REQUIRE(page.Await([&] { return page->info.contains("services") && page->info["services"].size() >= 6; }));
  REQUIRE(page.Await([&] { return page->info["scans"] == scans; }));

  Page late(viewer.port());
  REQUIRE(late.Await([&] { return late->complete; }));
  CHECK(late->tiles == page->tiles);

  Page returned(viewer.port(), "robot=0&epoch=" + std::to_string(page->epoch) + "&version=" + std::to_string(scans));
  REQUIRE(returned.Await([&] { return returned->num_robots > 0 && !returned->info.is_null(); }));
  CHECK(returned->num_begun == 0);
  CHECK(returned->num_whole_tiles == 0);

  CHECK(viewer.process().Interrupt() == 0);
  CHECK(stack.Finish());
}

TEST_CASE("the viewer and the owner of the map may be killed: the next page is whole again", "[viewer]") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Stack stack({url, folder / "out", {}, false});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher("sim:demo", "20"));
  auto viewer = std::make_unique<Viewer>(std::vector<std::string>{"--lcm-url", url}, folder);
  REQUIRE(viewer->AwaitReady());
  std::int64_t epoch = 0;
  {
    Page page(viewer->port());
    REQUIRE(page.Await([&] { return page->complete && page->version > 10; }));
    epoch = page->epoch;
    viewer->process().Signal(SIGKILL);
    CHECK_FALSE(page.Await([] { return false; }));
  }
  viewer = std::make_unique<Viewer>(std::vector<std::string>{"--lcm-url", url}, folder);
  REQUIRE(viewer->AwaitReady());
  Page page(viewer->port());
  REQUIRE(page.Await([&] { return page->complete && page->version > 20; }));
  const auto IsOfFirstOwner = [&] { return std::abs(page->epoch - epoch) < 100; };  // one counts its corrections
  CHECK(IsOfFirstOwner());
  REQUIRE(stack.Start("map_updater"));  // with another map, since there is no journal
  REQUIRE(page.Await([&] { return page->complete && !IsOfFirstOwner() && page->version > 10; }));
  stack["laser_publisher"].Signal(SIGINT);
  REQUIRE(stack["laser_publisher"].AwaitExit() == 0);
  REQUIRE(page.Await([&] { return page->ExploredTiles() == AskOwner(url); }));
}

TEST_CASE("a match is on the page within a moment, also when many come", "[viewer]") {
  ViewerOnBus on;
  Page& page = on.page;
  TestBus& bus = on.bus;
  for (int utime = 1; utime <= 300; ++utime) {
    bus->Publish(kCriticalRaysChannel, ScanOf(utime));
    bus->Publish(kScanMatchChannel, MatchOf(utime));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  REQUIRE(page.Await([&] { return page->robot_utime == 300; }));
  CHECK(page->num_robots < 250);  // no screen shows more than about 60 in a second
  CHECK(page->num_rays == 3);
  REQUIRE(page.Await([&] { return page->fitnesses.size() >= 290; }));
}

TEST_CASE("prints how long a match takes to a page", "[.viewer_latency]") {
  constexpr std::size_t kCount = 2000;
  ViewerOnBus on;
  Page& page = on.page;
  TestBus& bus = on.bus;
  std::vector<std::atomic<Clock::rep>> sent(kCount + 1);
  std::thread publisher([&] {
    for (std::size_t utime = 1; utime <= kCount; ++utime) {
      bus->Publish(kCriticalRaysChannel, ScanOf(static_cast<std::int64_t>(utime)));
      sent[utime] = Clock::now().time_since_epoch().count();
      bus->Publish(kScanMatchChannel, MatchOf(static_cast<std::int64_t>(utime)));
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
  });
  std::vector<double> latencies_ms;
  std::int64_t last = 0;
  CHECK(page.Await([&] {
    if (std::exchange(last, page->robot_utime) != page->robot_utime) {
      const Clock::duration age =
          Clock::now().time_since_epoch() - Clock::duration(sent[static_cast<std::size_t>(page->robot_utime)]);
      latencies_ms.push_back(std::chrono::duration<double, std::milli>(age).count());
    }
    return last == kCount;
  }));
  publisher.join();
  latencies_ms.erase(latencies_ms.begin(), latencies_ms.begin() + 40);  // until the sender is believed
  std::sort(latencies_ms.begin(), latencies_ms.end());
  for (const double share : {0.5, 0.99, 1.0}) {
    const auto at = static_cast<std::size_t>(share * static_cast<double>(latencies_ms.size() - 1));
    std::printf("%3.0f %% of %zu matches: within %.1f ms\n", 100.0 * share, latencies_ms.size(), latencies_ms[at]);
  }
}

TEST_CASE("the robot stays on the map that is shown, whichever of the two maps a loop has corrected first",
          "[viewer]") {
  ViewerOnBus on;
  Page& page = on.page;
  TestBus& bus = on.bus;
  MapOwner owner;
  owner.Serve(*bus);
  const auto Say = [&](std::int64_t utime, double matched_x_m, double local_x_m) {
    scan_match_t match = MatchOf(utime);
    match.x_m = matched_x_m;
    match.map_version = utime;
    bus->Publish(kScanMatchChannel, match);
    bus->Publish(kLocalPoseChannel, ToPoseMessage(utime, {local_x_m, 0.0, 0.0}));
  };
  const auto Shows = [&](std::int64_t utime, double x_m) {
    return on.Await([&] { return page->robot_utime == utime && page->robot_x_m == Approx(x_m); });
  };
  Say(1, 10.0, 10.0);
  CHECK(Shows(1, 10.0));  // nothing else is known
  owner.history = {FromMessage(MatchOf(1))};
  owner.history[0].T_map_laser.x_m = 15.0;
  REQUIRE(on.Await([&] { return page->version == 1; }));
  Say(2, 11.0, 11.0);
  CHECK(Shows(2, 16.0));  // the map that scans are matched to does not know yet
  Say(3, 17.0, 12.0);
  CHECK(Shows(3, 17.0));  // now it does
}

TEST_CASE("what a run leaves, its loops and its path, is not shown of the next one, on a finished map say",
          "[viewer]") {
  ViewerOnBus on;
  Page& page = on.page;
  TestBus& bus = on.bus;
  MapOwner owner;
  owner.history = {FromMessage(MatchOf(1)), FromMessage(MatchOf(2))};
  owner.history[1].T_map_laser.x_m = 3.0;
  owner.loops = {map_loop_t{}};
  owner.Serve(*bus);
  const auto Shows = [&](std::size_t num_loops, std::size_t num_points) {
    return on.Await([&] {
      return page->info.contains("loops") && page->info["loops"].size() == num_loops && page->path.size() == num_points;
    });
  };
  REQUIRE(Shows(1, 2));

  ++owner.epoch;  // of another log, which has the same utimes
  owner.history.pop_back();
  owner.loops.clear();
  bus->Publish(kScanMatchChannel, MatchOf(1));
  CHECK(Shows(0, 1));
}

TEST_CASE("what is no message is dropped and counted, and the viewer goes on", "[viewer]") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Viewer viewer({"--lcm-url", url}, folder);
  REQUIRE(viewer.AwaitReady());
  TestBus bus(url);
  scan_match_t match = MatchOf(1);
  match.fitness = std::numeric_limits<double>::quiet_NaN();
  bus->Publish(kScanMatchChannel, match);
  service_status_t status{};
  for (int i = 0; i < 100; ++i) {
    status.name = "service" + std::to_string(i) + "\xff<script>";
    bus->Publish(ServiceStatusChannel("any").c_str(), status);
  }
  REQUIRE(bus.Await(
      [&] { return bus.Count("map_viewer.SCAN_MATCH_malformed") == 1 && bus.Count("map_viewer.status_ignored") > 0; }));
  Page page(viewer.port());
  REQUIRE(page.Await([&] { return page->info.contains("services"); }));
  CHECK(page->info["services"].size() <= 65);
  CHECK(viewer.process().Interrupt() == 0);
}
