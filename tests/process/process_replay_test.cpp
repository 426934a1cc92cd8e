// Process replay: recorded inputs go to one process alone, and what it says is compared bit by bit with what the
// algorithm computes from the same inputs in the process of the test.

#include <csignal>

#include "catch.hpp"
#include "common/graph/mapper.hpp"
#include "common/match/default_matcher.hpp"
#include "common/results/results.hpp"
#include "common/scan/ray_selector.hpp"
#include "map_owner.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

/// What the algorithm makes of one scan.
struct Step {
  LaserScan scan;
  CriticalRays rays;
  ScanMatch match;
  MapDelta delta;
};

struct Recording {
  std::vector<Step> steps;
  std::vector<ScanMatch> history;
  DenseGrid map;  ///< after the last step
};

/// The loop of Slam::Process with all that passes from stage to stage kept.
Recording Record(const std::vector<LaserScan>& scans, const Parameters& parameters) {
  Recording recording;
  RaySelector selector(parameters);
  const auto matcher = DefaultMatcher(parameters)(parameters.update.cell_size_m);
  Mapper mapper(parameters.update, parameters.loops);
  TrackingState tracking;
  for (const LaserScan& scan : scans) {
    const CriticalRays rays = selector.Select(scan);
    ScanMatch match = matcher->Match(rays, tracking, {});
    match.map_version = mapper.local().version();
    const MapDelta delta = mapper.Integrate(&rays, match).delta;
    matcher->Apply(delta.tiles);
    tracking.Add(match);
    recording.history.push_back(match);
    recording.steps.push_back({scan, rays, match, delta});
  }
  recording.map = matcher->map().ToDenseGrid();
  return recording;
}

std::vector<std::vector<std::string>> Profiles() { return {{}, {"--profile", "paper"}}; }

std::vector<std::string> With(std::vector<std::string> flags, const std::vector<std::string>& more) {
  flags.insert(flags.end(), more.begin(), more.end());
  return flags;
}

}  // namespace

TEST_CASE(
    "ray_selector answers each recorded scan with the rays that the algorithm selects, and once more when asked") {
  for (const auto& profile : Profiles()) {
    const Recording recording = Record(TakeScans("sim:demo", 30, 10), ParametersOf(profile));
    const TemporaryFolder folder;
    const std::string url = MakeBusUrl();
    Process selector("ray_selector", With({"--lcm-url", url}, profile), folder / "log");
    REQUIRE(selector.AwaitReady());
    TestBus bus(url);
    std::vector<critical_rays_t> answers;
    bus->Subscribe<critical_rays_t>(kCriticalRaysChannel,
                                    [&](const critical_rays_t& answer) { answers.push_back(answer); });

    for (const Step& step : recording.steps) {
      for (int time = 0; time < 2; ++time) {
        answers.clear();
        bus->Publish(kLaserChannel, ToMessage(step.scan));
        REQUIRE(bus.Await([&] { return !answers.empty(); }));
        CHECK(Encode(answers.front()) == Encode(ToMessage(step.rays)));
      }
    }
    CHECK(selector.Interrupt() == 0);
  }
}

TEST_CASE(
    "rrhc_matcher answers recorded rays and maps with the pose that the algorithm finds, and once more when asked") {
  for (const auto& profile : Profiles()) {
    const Parameters parameters = ParametersOf(profile);
    const Recording recording = Record(TakeScans("sim:demo", 20, 10), parameters);
    const TemporaryFolder folder;
    const std::string url = MakeBusUrl();
    Process matcher("rrhc_matcher", With({"--lcm-url", url, "--lockstep", "--no-odometry"}, profile), folder / "log");
    REQUIRE(matcher.AwaitReady());
    TestBus bus(url);
    MapOwner owner(parameters.update);
    owner.Serve(*bus);
    std::vector<scan_match_t> answers;
    std::vector<bot_core::pose_t> poses;
    bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t& answer) { answers.push_back(answer); });
    bus->Subscribe<bot_core::pose_t>(kPoseChannel, [&](const bot_core::pose_t& pose) { poses.push_back(pose); });
    REQUIRE(bus.Await([&] { return owner.num_pages > 0; }));

    for (const Step& step : recording.steps) {
      for (int time = 0; time < 2; ++time) {
        answers.clear();
        poses.clear();
        bus->Publish(kCriticalRaysChannel, ToMessage(step.rays));
        REQUIRE(bus.Await([&] { return !answers.empty() && !poses.empty(); }));
        CHECK(Encode(answers.front()) == Encode(ToMessage(step.match)));
        CHECK(poses.front().utime == step.scan.utime);
        CHECK(poses.front().pos[0] == step.match.T_map_laser.x_m);
        CHECK(poses.front().pos[1] == step.match.T_map_laser.y_m);
      }
      for (const map_delta_t& part : owner.Answer(step.match, step.delta.tiles)) bus->Publish(kMapDeltaChannel, part);
    }
    CHECK(matcher.Interrupt() == 0);
  }
}

TEST_CASE("a matcher goes on where the owner has lost its last match again, and the publisher has gone on") {
  const Recording recording = Record(TakeScans("sim:demo", 3, 10), {});
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
  for (const Step& step : recording.steps) {  // which the owner has taken, and has forgotten by now
    REQUIRE(bus.Await([&] {
      bus->Publish(kCriticalRaysChannel, ToMessage(step.rays));
      return !answers.empty() && answers.back().utime == step.scan.utime;
    }));
  }
  CHECK(matcher.Interrupt() == 0);
  CHECK(matcher.errors().find("has lost scan") != std::string::npos);
}

TEST_CASE("map_updater answers recorded scans and poses with the change of the map, and tells a newcomer all of it") {
  for (const auto& profile : Profiles()) {
    const Parameters parameters = ParametersOf(profile);
    const Recording recording = Record(TakeScans("sim:demo", 60, 10), parameters);
    const TemporaryFolder folder;
    const std::string url = MakeBusUrl();
    Process updater("map_updater", With({"--lcm-url", url}, profile), folder / "log");
    REQUIRE(updater.AwaitReady());
    TestBus bus(url);
    std::vector<map_delta_t> parts;
    bus->Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t& part) { parts.push_back(part); });
    const auto HasAllParts = [&] {
      return !parts.empty() && static_cast<std::int32_t>(parts.size()) == parts.front().num_parts;
    };

    for (const Step& step : recording.steps) {
      for (int time = 0; time < 2; ++time) {
        parts.clear();
        bus->Publish(kCriticalRaysChannel, ToMessage(step.rays));
        bus->Publish(kScanMatchChannel, ToMessage(step.match));
        REQUIRE(bus.Await(HasAllParts));
        map_delta_t joined = parts.front();  // the parts one behind the other are the change
        for (std::size_t i = 1; i < parts.size(); ++i) {
          CHECK(parts[i].part == static_cast<std::int32_t>(i));
          CHECK(parts[i].version == step.delta.version);
          joined.tiles.insert(joined.tiles.end(), parts[i].tiles.begin(), parts[i].tiles.end());
        }
        joined.num_tiles = static_cast<std::int32_t>(joined.tiles.size());
        map_delta_t expected{.utime = step.scan.utime,
                             .epoch = joined.epoch,  // drawn
                             .version = step.delta.version,
                             .cell_size_m = parameters.update.cell_size_m,
                             .num_parts = joined.num_parts,
                             .num_tiles = static_cast<std::int32_t>(step.delta.tiles.size())};
        for (const TileChange& change : step.delta.tiles) expected.tiles.push_back(ToMessage(change));
        CHECK(Encode(joined) == Encode(expected));
      }
    }

    ByteMap map(parameters.update.cell_size_m);
    std::vector<ScanMatch> history;
    map_request_t request{.requester = 77, .epoch = parts.front().epoch};
    std::vector<map_page_t> pages;
    bus->Subscribe<map_page_t>(kMapPageChannel, [&](const map_page_t& page) { pages.push_back(page); });
    while (request.first_tile >= 0) {
      pages.clear();
      bus->Publish(kMapRequestChannel, request);
      REQUIRE(bus.Await([&] { return !pages.empty(); }));
      CHECK(Encode(pages.front().request) == Encode(request));
      CHECK(Encode(pages.front()).size() < 40000);
      for (const map_tile_t& tile : pages.front().tiles) CHECK(map.Apply(FromMessage(tile)));
      for (const scan_match_t& match : pages.front().matches) history.push_back(FromMessage(match));
      request.first_tile = pages.front().next_tile;
      request.first_match = pages.front().next_match;
    }
    CHECK(history == recording.history);
    CHECK(map.ToDenseGrid().cells == recording.map.cells);
    CHECK(updater.Interrupt() == 0);
  }
}

TEST_CASE("map_exporter writes the files that belong to a map whose owner it asks") {
  const Parameters parameters;
  const Recording recording = Record(TakeScans("sim:demo", 40, 10), parameters);
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Process exporter("map_exporter", {"--lcm-url", url, "--out", folder / "out"}, folder / "log");
  REQUIRE(exporter.AwaitReady());
  TestBus bus(url);
  MapOwner owner(parameters.update);
  owner.Serve(*bus);
  REQUIRE(bus.Await([&] { return owner.num_pages > 0; }));
  for (const Step& step : recording.steps) {
    bus->Publish(kCriticalRaysChannel, ToMessage(step.rays));
    owner.Answer(step.match, step.delta.tiles);
  }
  exporter.Signal(SIGINT);
  REQUIRE(bus.Await([&] { return !exporter.IsRunning(); }));  // at the end it asks for what it may lack
  CHECK(exporter.AwaitExit() == 0);

  Results expected;
  expected.grid = recording.map;
  expected.matches = recording.history;
  expected.last_scan = recording.steps.back().rays;
  RunStatistics statistics;
  for (const Step& step : recording.steps) {
    statistics.Add(step.rays.utime, step.rays.rays);
    statistics.Add(step.match);
  }
  expected.summary.emplace().values = statistics.values();
  expected.summary->explored_area_m2 = ComputeExploredArea(expected.grid);
  expected.summary->verdict = Judge(statistics, owner.map);
  expected.name = "out";
  WriteResults(folder / "expected", expected);
  for (const char* file : {"map.png", "map.yaml", "overview.png", "trajectory.tum"}) {
    INFO(file);
    CHECK(ReadFile(folder / "out" / file) == ReadFile(folder / "expected" / file));
  }
  CHECK(ReadFile(folder / "out/summary.json").find("\"scans\": 40,") != std::string::npos);
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
