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
  scan_match_t match{};
  match.utime = utime;
  match.x_m = kFar_m;
  match.fitness = 0.9;
  match.num_critical = 40;
  match.state = scan_match_t::OK;
  return match;
}

/// A delta with a tile of walls.
map_delta_t ForgedDelta(const map_delta_t& like) {
  map_delta_t delta = like;
  delta.num_parts = 1;
  delta.part = 0;
  delta.num_tiles = 1;
  delta.tiles = {{3, 3, 5, {0, 0, 0, 1, 0}}};
  delta.num_matches = 1;
  delta.matches = {ForgedMatch(like.utime + 1)};
  return delta;
}

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
    if (delta.num_requests != 0 || delta.num_matches == 0) return;
    map_delta_t next = ForgedDelta(delta);
    next.base_version = delta.version;
    next.version = delta.version + 1;
    bus->Publish(kMapDeltaChannel, next);
  });
}

/// A replica that is made to ask is answered with a page of another epoch, and with cells of another size.
void ForgePages(TestBus& bus) {
  bus->Subscribe<map_request_t>(kMapRequestChannel, [&](const map_request_t& request) {
    map_delta_t page = ForgedDelta({});
    page.utime = 1;
    page.epoch = request.epoch + 1;
    page.version = 1;
    page.base_version = 0;
    page.cell_size_m = 0.5;
    page.num_requests = 1;
    page.request = {request};
    page.next_tile = -1;
    page.next_match = 1;
    page.num_tracking = 1;
    page.tracking = {tracking_state_t{1, 0, 1, 0, 0, {}, 1, {ForgedMatch(1)}, {}, 0, {}, 0, 0, {}, 0.0}};
    bus->Publish(kMapDeltaChannel, page);
    page.epoch = request.epoch;
    if (page.epoch != 0) bus->Publish(kMapDeltaChannel, page);
  });
  bus->Subscribe<critical_rays_t>(kCriticalRaysChannel, [&](const critical_rays_t& rays) {
    map_delta_t unheard_of = ForgedDelta({});
    unheard_of.utime = rays.utime;
    unheard_of.epoch = 12345;
    unheard_of.version = unheard_of.base_version = 1'000'000;
    unheard_of.cell_size_m = 0.5;
    bus->Publish(kMapDeltaChannel, unheard_of);
  });
}

/// Pages of another map for who looks at it, asked for or not.
void ForgeWholeMaps(TestBus& bus) {
  const auto Publish = [&](const map_request_t& request) {
    map_delta_t page = ForgedDelta({});
    page.utime = 1;
    page.epoch = 12345;
    page.version = 1;
    page.base_version = 0;
    page.num_requests = 1;
    page.request = {request};
    page.next_tile = -1;
    page.next_match = 1;
    bus->Publish(kWholeMapChannel, page);
  };
  bus->Subscribe<map_request_t>(kMapRequestChannel, [=](const map_request_t& request) { Publish(request); });
  bus->Subscribe<critical_rays_t>(kCriticalRaysChannel, [=](const critical_rays_t&) {
    Publish({4711, 1, 0, 0, 0, 0, -1, 1, 0, 0});
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
    for (int i = 0; i < 20; ++i) bus->Publish(kMapRequestChannel, map_request_t{4711, 1, 0, 0, 0, 0, -1, 0, 0, 0});
  });
}

struct Course {
  TemporaryFolder folder;
  std::string url = MakeBusUrl();
  Stack stack{{url, folder / "out", {}}};

  Course() {
    WriteScans(TakeScans("sim:demo", 300), folder / "run.lcm");
    REQUIRE(Run("slam_offline", {folder / "run.lcm", "--out", folder / "offline"}, folder / "log") == 0);
    REQUIRE(stack.StartServices());
  }
  void CheckSameMap() {
    CHECK(stack.Finish());
    for (const char* file : {"map.png", "trajectory.tum"}) {
      INFO(file);
      CHECK(ReadFile(folder / "out" / file) == ReadFile(folder / "offline" / file));
    }
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
      {"pages", ForgePages, kMapDeltaChannel, {"rrhc_matcher"}},
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
  const std::string log = folder / "run.lcm";
  WriteScans(TakeScans("sim:demo", 300), log);
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
    std::vector<std::string> arguments{log, "--out", folder / name};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    REQUIRE(Run("slam_offline", arguments, folder / "log") == 0);
    const std::filesystem::path out = folder / (std::string(name) + "_attacked");
    arguments[2] = out;
    arguments.insert(arguments.end(), {"--lcm-url", url});
    TestBus bus(url);
    ForgeRequests(bus);
    Process stack("run_stack", arguments, folder / "log");
    CHECK(bus.Await([&] { return !stack.IsRunning(); }));
    INFO(stack.errors());
    CHECK(stack.AwaitExit() == 0);
    for (const char* file : {"map.png", "trajectory.tum"}) {
      INFO(file);
      CHECK((ReadFile(out / file) == ReadFile(folder / name / file)));
    }
    const std::string said = ReadFile(out / "log" / (std::string(service) + ".log"));
    const std::size_t at = said.find("another program on this bus forges");
    CHECK(at != std::string::npos);
    CHECK(said.find("another program on this bus forges", at + 1) == std::string::npos);
    if (service == std::string("rrhc_matcher")) {  // the exporter's last status is older
      CHECK(ReadFile(out / "summary.json").find("rrhc_matcher.pages_refused") != std::string::npos);
    }
  }
}

TEST_CASE("matches that are forged from the first scan on are refused, and the map is the right one") {
  Course course;
  TestBus bus(course.url);
  ForgeMatches(bus);
  REQUIRE(course.stack.StartPublisher(course.folder / "run.lcm", "max"));
  CHECK(bus.Await([&] { return !course.stack["laser_publisher"].IsRunning(); }));
  CHECK(course.stack["map_updater"].errors().find("is refused: another process") != std::string::npos);
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
  WriteScans(TakeScans("sim:demo", 300), folder / "run.lcm");
  const std::string url = MakeBusUrl();
  Stack stack({url, folder / "out", {}});
  MapWatcher map(url);
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(folder / "run.lcm", "max"));
  REQUIRE(map.AwaitVersion(5));
  stack["map_updater"].Signal(SIGSTOP);
  const auto Says = [&](const char* service, const std::string& text) {
    return WaitUntil([&] { return stack[service].errors().find(text) != std::string::npos; });
  };
  CHECK(Says("laser_publisher", "laser_publisher: has waited 5 s for the map of scan "));
  CHECK(Says("rrhc_matcher", "rrhc_matcher: has waited 5 s for "));
  stack["map_updater"].Signal(SIGCONT);
  REQUIRE(map.AwaitVersion(20));
  stack["rrhc_matcher"].Signal(SIGSTOP);
  CHECK(Says("map_updater", "map_updater: has waited 5 s for SCAN_MATCH of scan "));
  stack["rrhc_matcher"].Signal(SIGCONT);
  CHECK(stack.Finish());
}
