// Messages that are well formed and look like those of our own processes, but are another's: the map is the one of a
// run without them, or nothing is mapped while they come.

#include <csignal>
#include <limits>
#include <thread>

#include "catch.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

/// A process of another on the bus: hears what it wants and sends what it likes.
using Attack = std::function<void(TestBus& bus)>;

constexpr double kFar_m = 7.0;

scan_match_t ForgedMatch(std::int64_t utime) {
  return {.utime = utime, .x_m = kFar_m, .fitness = 0.9, .num_critical = 40, .state = scan_match_t::OK};
}

const std::vector<map_tile_t> kWalls{{3, 3, 5, {0, 0, 0, 1, 0}}};

/// Before the matcher's: it answers as soon as the rays are heard.
void ForgeMatches(TestBus& bus) {
  bus->Subscribe<critical_rays_t>(kCriticalRaysChannel, [&](const critical_rays_t& rays) {
    bus->Publish(kScanMatchChannel, ForgedMatch(rays.utime));
  });
}

/// Before the selector's.
void ForgeRays(TestBus& bus) {
  bus->Subscribe<bot_core::planar_lidar_t>(kLaserChannel, [&](const bot_core::planar_lidar_t& laser) {
    bus->Publish(kCriticalRaysChannel,
                 critical_rays_t{laser.utime, 3, {-0.5f, 0.0f, 0.5f}, {1.0f, 2.0f, 3.0f}, 3, {0, 1, 2}, 0, {}});
  });
}

/// Before the owner makes it.
void ForgeNextVersion(TestBus& bus) {
  bus->Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t& delta) {
    map_delta_t next = delta;
    next.version += 1;
    next.num_parts = next.num_tiles = 1;
    next.part = 0;
    next.tiles = kWalls;
    bus->Publish(kMapDeltaChannel, next);
  });
}

/// The last page of another map.
map_page_t ForgedPage(const map_request_t& request) {
  return {.request = request,
          .epoch = 12345,
          .version = 1,
          .cell_size_m = 0.5,
          .next_tile = -1,
          .next_match = 1,
          .num_tiles = 1,
          .tiles = kWalls,
          .num_matches = 1,
          .matches = {ForgedMatch(1)},
          .num_tracking = 1,
          .tracking = {{.num_scans = 1, .newest_utime = 1, .num_recent = 1, .recent = {ForgedMatch(1)}}}};
}

/// A matcher that is made to ask is answered with a page of another map, and of its own with cells of another size.
void ForgePages(TestBus& bus) {
  bus->Subscribe<map_request_t>(kMapRequestChannel, [&](const map_request_t& request) {
    map_page_t page = ForgedPage(request);
    bus->Publish(kMapPageChannel, page);
    page.epoch = request.epoch;
    if (page.epoch != 0) bus->Publish(kMapPageChannel, page);
  });
  bus->Subscribe<critical_rays_t>(kCriticalRaysChannel, [&](const critical_rays_t& rays) {
    bus->Publish(kMapPageChannel, ForgedPage({.requester = 4711, .question = 1}));
    bus->Publish(
        kMapDeltaChannel,
        map_delta_t{.utime = rays.utime, .epoch = 12345, .version = 1'000'000, .cell_size_m = 0.5, .num_parts = 1});
  });
}

/// Pages of another map for who looks at it, asked for or not.
void ForgeWholeMaps(TestBus& bus) {
  bus->Subscribe<map_request_t>(
      kMapRequestChannel, [&](const map_request_t& request) { bus->Publish(kWholeMapChannel, ForgedPage(request)); });
  bus->Subscribe<critical_rays_t>(kCriticalRaysChannel, [&](const critical_rays_t&) {
    bus->Publish(kWholeMapChannel, ForgedPage({.requester = 4711, .question = 1, .whole = 1}));
  });
}

/// That each scan is in the map already, at another place.
void ForgeAnswers(TestBus& bus) {
  bus->Subscribe<critical_rays_t>(kCriticalRaysChannel, [&](const critical_rays_t& rays) {
    bus->Publish(kScanAnswerChannel, scan_answer_t{rays.utime, 12345, 0, rays.utime + 1, 1, {ForgedMatch(rays.utime)}});
  });
}

/// Copies each request of the others, with the cursor behind the last tile: the owner's answer says that there are no
/// more.
void ForgeRequests(TestBus& bus) {
  constexpr std::int32_t kBehindAll = std::numeric_limits<std::int32_t>::max();
  bus->Subscribe<map_request_t>(kMapRequestChannel, [&](const map_request_t& request) {
    if (request.first_tile == kBehindAll) return;  // its own, or of a replica that has all tiles
    map_request_t forged = request;
    forged.first_tile = kBehindAll;
    bus->Publish(kMapRequestChannel, forged);
  });
}

/// Asks for the whole map, again and again.
void AskForEverything(TestBus& bus) {
  bus->Subscribe<bot_core::planar_lidar_t>(kLaserChannel, [&](const bot_core::planar_lidar_t&) {
    for (int i = 0; i < 20; ++i) bus->Publish(kMapRequestChannel, map_request_t{.requester = 4711, .question = 1});
  });
}

struct Course {
  TemporaryFolder folder;
  std::string url = MakeBusUrl();
  Stack stack{{url, folder / "out", {}}};

  Course() {
    folder.Map(folder.Write(TakeScans("sim:demo", 300), "run.lcm"), "offline");
    REQUIRE(stack.StartServices());
  }
  void CheckSameMap() {
    CHECK(stack.Finish());
    folder.CheckSame("out", "offline");
  }
};

}  // namespace

TEST_CASE("messages that are forged during a run in lockstep change nothing in its map, are counted, and said once") {
  struct Forgery {
    const char* name;
    Attack attack;
    const char* channel;
    std::vector<std::string> refused_by;
  };
  const std::vector<Forgery> forgeries{
      {"matches", ForgeMatches, kScanMatchChannel, {"map_updater"}},
      {"rays", ForgeRays, kCriticalRaysChannel, {"map_updater", "rrhc_matcher"}},
      {"next versions", ForgeNextVersion, kMapDeltaChannel, {"rrhc_matcher", "laser_publisher"}},
      {"pages", ForgePages, kMapPageChannel, {"rrhc_matcher"}},
      {"answers", ForgeAnswers, kScanAnswerChannel, {"rrhc_matcher", "laser_publisher"}},
      {"whole maps", ForgeWholeMaps, kWholeMapChannel, {"map_exporter"}}};
  for (const auto& [name, attack, channel, refused_by] : forgeries) {
    INFO(name);
    Course course;
    MapWatcher map(course.url);
    TestBus bus(course.url);
    REQUIRE(course.stack.StartPublisher(course.folder / "run.lcm", "max"));
    REQUIRE(map.AwaitVersion(5));
    course.stack["laser_publisher"].Signal(SIGSTOP);
    attack(bus);
    course.stack["laser_publisher"].Signal(SIGCONT);
    CHECK(bus.Await([&] { return !course.stack["laser_publisher"].IsRunning(); }));
    for (const std::string& service : refused_by) {
      const std::string errors = course.stack[service].errors();
      INFO(errors);
      const std::size_t said = errors.find(std::string(channel) + " from ");
      CHECK(said != std::string::npos);
      CHECK(errors.find(std::string(channel) + " from ", said + 1) == std::string::npos);
    }
    course.CheckSameMap();
    const std::string summary = ReadFile(course.folder / "out/summary.json");
    for (const std::string& service : refused_by) {
      if (service == "laser_publisher") continue;  // its last status is older
      CHECK(summary.find(service + "." + channel + "_refused") != std::string::npos);
    }
  }
}

TEST_CASE("requests that are forged in another's name leave no hole in its map; that is counted, and said once") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 300), "run.lcm");
  struct Case {
    const char* name;
    const char* service;  ///< that asks for pages
    std::vector<std::string> flags;
  };
  const std::vector<Case> cases{{"mapped", "map_exporter", {}},
                                {"localised", "rrhc_matcher", {"--localize", folder / "mapped"}}};
  for (const auto& [name, service, flags] : cases) {
    INFO(name);
    const std::string url = MakeBusUrl();
    folder.Map(log, name, flags);
    const std::string attacked = std::string(name) + "_attacked";
    TestBus bus(url);
    ForgeRequests(bus);
    Process stack = folder.StartStack(log, attacked, url, flags);
    CHECK(bus.Await([&] { return !stack.IsRunning(); }));
    INFO(stack.errors());
    CHECK(stack.AwaitExit() == 0);
    folder.CheckSame(attacked, name);
    const std::string said = ReadFile(folder / attacked / "log" / (std::string(service) + ".log"));
    const std::size_t at = said.find("another program on this bus forges");
    CHECK(at != std::string::npos);
    CHECK(said.find("another program on this bus forges", at + 1) == std::string::npos);
    if (service == std::string("rrhc_matcher")) {  // the exporter's last status is older
      CHECK(ReadFile(folder / attacked / "summary.json").find("rrhc_matcher.pages_refused") != std::string::npos);
    }
  }
}

TEST_CASE("who says where the robot is while a map is made changes nothing in it, which is counted and said once") {
  Course course;
  TestBus bus(course.url);
  REQUIRE(course.stack.StartPublisher(course.folder / "run.lcm", "max"));
  CHECK(bus.Await([&] {
    bus->Publish(kStartPoseChannel, ToPoseMessage(0, {5.0, 5.0, 1.0}));
    return !course.stack["laser_publisher"].IsRunning();
  }));
  CHECK(CountOf("START_POSE is ignored", course.stack["rrhc_matcher"].errors()) == 1);
  course.CheckSameMap();
}

TEST_CASE("who asks for the map without a pause is answered seldom, and does not keep the others from mapping") {
  Course course;
  TestBus bus(course.url);
  AskForEverything(bus);
  REQUIRE(course.stack.StartPublisher(course.folder / "run.lcm", "max"));
  CHECK(bus.Await([&] { return !course.stack["laser_publisher"].IsRunning(); }));
  course.CheckSameMap();
  CHECK(ReadFile(course.folder / "out/summary.json").find("map_updater.map_requests_refused") != std::string::npos);
}

TEST_CASE("a stall in lockstep is said by those who wait, each what for, once") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 300), "run.lcm");
  const std::string url = MakeBusUrl();
  Stack stack({url, folder / "out", {}});
  MapWatcher map(url);
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(log, "max"));
  REQUIRE(map.AwaitVersion(5));
  stack["map_updater"].Signal(SIGSTOP);
  CHECK(stack["laser_publisher"].AwaitSaid("laser_publisher: has waited 5 s for the map of scan "));
  CHECK(stack["rrhc_matcher"].AwaitSaid("rrhc_matcher: has waited 5 s for "));
  stack["map_updater"].Signal(SIGCONT);
  REQUIRE(map.AwaitVersion(20));
  stack["rrhc_matcher"].Signal(SIGSTOP);
  CHECK(stack["map_updater"].AwaitSaid("map_updater: has waited 5 s for SCAN_MATCH of scan "));
  stack["rrhc_matcher"].Signal(SIGCONT);
  CHECK(stack.Finish());
}

TEST_CASE("scans and junk that others send beside our publisher are no part of its recording, and are named") {
  Course course;
  TestBus bus(course.url);
  std::int64_t num_forged = 0;
  bus->Subscribe<bot_core::planar_lidar_t>(kLaserChannel, [&](const bot_core::planar_lidar_t& laser) {
    if (laser.utime % 10 != 0) return;  // its own
    bot_core::planar_lidar_t forged = laser;
    forged.utime += 1;
    for (float& range : forged.ranges) range *= 1.2f;
    bus->Publish(kLaserChannel, forged);
    bus->Publish(kLaserChannel, ToPoseMessage(laser.utime, {}));  // no scan
    ++num_forged;
  });
  REQUIRE(course.stack.StartPublisher(course.folder / "run.lcm", "max"));
  CHECK(bus.Await([&] { return !course.stack["laser_publisher"].IsRunning(); }));
  CHECK(num_forged > 200);
  CHECK(CountOf("LASER: scans come from ", course.stack["ray_selector"].errors()) == 1);
  course.CheckSameMap();
  const auto summary = course.folder.Summary("out");
  CHECK(summary["left_out"] == 0);
  CHECK(summary["verdict"]["trust"] == course.folder.Summary("offline")["verdict"]["trust"]);
  CHECK(summary["counts"]["ray_selector.scans_refused"] > 200);
  CHECK(summary["counts"]["ray_selector.messages_refused"] > 200);
}
