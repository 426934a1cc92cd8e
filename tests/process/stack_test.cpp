// The five processes together, against the same algorithm in one process: same log, same seed, same files.

#include <algorithm>
#include <csignal>
#include <fstream>
#include <limits>

#include "catch.hpp"
#include "processes.hpp"
#include "real_logs.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

/// Results whose overview.png is to be that in offline/: it shows the folder's name.
const std::string kNamedAlike = "stack/offline";

/// A log of scans, and in offline/ what one process makes of it.
std::string WriteMapped(const TemporaryFolder& folder, const std::vector<LaserScan>& scans,
                        const std::vector<std::string>& flags = {}, const std::string& name = "offline") {
  const std::string log = folder.Write(scans, name + ".lcm");
  folder.Map(log, name, flags);
  return log;
}

}  // namespace

TEST_CASE("five processes in lockstep make the files that one process makes, in each profile") {
  for (const std::string profile : {"default", "paper"}) {
    INFO(profile);
    const TemporaryFolder folder;
    folder.MapWithStack(WriteMapped(folder, TakeScans("sim:demo", 250, 2), {"--profile", profile}), kNamedAlike,
                        {"--profile", profile});
    folder.CheckSame(kNamedAlike, "offline", {"map.png", "map.yaml", "trajectory.tum", "overview.png"});
    CHECK(CountLines(ReadFile(folder / kNamedAlike / "trajectory.tum")) == 250);
  }
}

TEST_CASE("five processes in lockstep make the files that one process makes from a real log", "[logs]") {
  const auto log = FindRealLog("radish/fr079.clf.gz");
  if (!log) return;
  const TemporaryFolder folder;
  folder.MapWithStack(WriteMapped(folder, TakeScans(*log, 400), {"--preset", "sick"}), kNamedAlike,
                      {"--preset", "sick"});
  folder.CheckSame(kNamedAlike, "offline", {"map.png", "map.yaml", "trajectory.tum", "overview.png"});
}

TEST_CASE(
    "a log that lcm-logplayer plays into the running services gives the map of lockstep, and no scan is dropped") {
  const TemporaryFolder folder;
  if (folder.Run("/usr/bin/env", {"which", "lcm-logplayer"}).exit_code != 0) {
    WARN("skipped: lcm-logplayer is not installed");
    return;
  }
  // Few rays and a patient matcher: what a slow machine makes of the time is no concern of this test.
  std::ofstream(folder / "light.toml") << "rays_max = 60\nmap_wait_s = 60.0\n";
  const std::vector<std::string> flags{"--config", folder / "light.toml"};
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 40);  // 10 Hz, 4 s
  const std::string log = WriteMapped(folder, scans, flags);
  const std::string converted = folder / "converted.lcm";
  REQUIRE(folder.Run("laser_publisher", {log, "--lcm-url", "file://" + converted + "?mode=w"}).exit_code == 0);
  CHECK((ReadFile(converted) == ReadFile(log)));

  for (const std::string speed : {"1", "4"}) {
    INFO("speed " << speed);
    const std::string url = MakeBusUrl();
    Stack stack({.url = url, .out = folder / ("out" + speed), .flags = flags, .lockstep = false});
    REQUIRE(stack.StartServices());
    MapWatcher watcher(url);
    CHECK(folder.Run("/usr/bin/env", {"lcm-logplayer", "-s", speed, "-l", url, converted}).exit_code == 0);
    CHECK(watcher.AwaitScan(scans.back().utime));
    CHECK(stack.Finish());
    folder.CheckSame("out" + speed, "offline");
    CHECK(ReadFile(folder / ("out" + speed) / "summary.json").find("dropped") == std::string::npos);
  }
}

TEST_CASE("a scan whose rays all measured nothing is answered, counted, and leaves no trace on the map") {
  std::vector<LaserScan> scans = TakeScans("sim:demo", 20, 4);
  for (std::size_t i = 0; i < scans[10].ranges_m.size(); ++i) {
    scans[10].ranges_m[i] = i % 2 ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
  }
  const TemporaryFolder folder;
  const std::string log = WriteMapped(folder, scans);
  const std::string url = MakeBusUrl();
  Stack stack({url, folder / "out"});
  REQUIRE(stack.StartServices());
  TestBus bus(url);
  REQUIRE(stack.StartPublisher(log, "max"));
  CHECK(bus.Await([&] { return bus.Count("ray_selector.handled") == 20 && bus.Count("rrhc_matcher.handled") == 20; }));
  CHECK(bus.Count("ray_selector.scan_without_rays") == 1);
  CHECK(bus.Count("rrhc_matcher.lost") == 0);
  CHECK(stack.Finish());
  folder.CheckSame("out", "offline");
  for (const char* run : {"out", "offline"}) {
    const nlohmann::json summary = folder.Summary(run);
    CHECK(summary["without_rays"] == 1);
    CHECK(summary["lost"] == 0);
    CHECK(summary["on_map"] == 19);
  }
}

TEST_CASE("a process that nobody answers asks for the map more and more seldom") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  using Clock = std::chrono::steady_clock;
  std::vector<Clock::time_point> asked;
  bus->Subscribe<map_request_t>(kMapRequestChannel, [&](const map_request_t&) { asked.push_back(Clock::now()); });
  Process matcher("rrhc_matcher", {"--lcm-url", url}, folder / "log");
  REQUIRE(bus.Await([&] { return asked.size() >= 10; }));
  CHECK(asked.back() - asked.front() > std::chrono::seconds(3));  // pauses of 0.05 s, 0.1 s, ... up to 0.5 s
  CHECK(matcher.Interrupt() == 0);
}

TEST_CASE(
    "an exporter that starts in the middle of a run, and processes that are killed and started anew, change nothing") {
  const TemporaryFolder folder;
  const std::string log = WriteMapped(folder, TakeScans("sim:demo", 400, 2));
  const std::string url = MakeBusUrl();
  MapWatcher watcher(url);
  Stack stack({url, folder / "out"});
  for (const char* service : {"map_updater", "loop_closer", "rrhc_matcher", "ray_selector"}) {
    REQUIRE(stack.Start(service));
  }
  REQUIRE(stack.StartPublisher(log, "max"));
  std::int64_t version = 0;
  for (const char* service : {"map_exporter", "rrhc_matcher", "ray_selector", "map_exporter", "rrhc_matcher"}) {
    REQUIRE(watcher.AwaitVersion(version += 60));
    INFO(service);
    CHECK(stack.Start(service));
  }
  CHECK(stack.Finish());
  folder.CheckSame("out", "offline");
}

TEST_CASE("Ctrl-C in the middle of run_stack leaves all files, and the map of the scans that the trajectory has") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 3000);
  const std::string url = MakeBusUrl();
  MapWatcher watcher(url);
  Process run_stack = folder.StartStack(folder.Write(scans, "run.lcm"), "out", url);
  REQUIRE(watcher.AwaitVersion(150));
  CHECK(run_stack.Interrupt() == 0);

  const std::size_t num_mapped = CountLines(ReadFile(folder / "out/trajectory.tum"));
  INFO(run_stack.errors());
  REQUIRE(num_mapped >= 150);
  REQUIRE(num_mapped < scans.size());
  WriteMapped(folder, {scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(num_mapped)});
  folder.CheckSame("out", "offline");
  CHECK(fs::file_size(folder / "out/overview.png") > 0);
  CHECK(folder.Summary("out")["scans"] == num_mapped);
}

TEST_CASE("laser_publisher goes on where its --position says, and refuses one that says nothing") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 30), "run.lcm");
  const std::string position = folder / "position";
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  int num_scans = 0;
  bus->Subscribe<bot_core::planar_lidar_t>(kLaserChannel, [&](const auto&) { ++num_scans; });
  const std::vector<std::string> arguments{log, "--rate", "1000", "--lcm-url", url, "--position", position};
  REQUIRE(folder.Run("laser_publisher", arguments).exit_code == 0);
  CHECK(bus.Await([&] { return num_scans == 30; }));
  CHECK(ReadFile(position) == "00000000000000000030\n");
  std::ofstream(position) << "00000000000000000025\n";
  REQUIRE(folder.Run("laser_publisher", arguments).exit_code == 0);
  CHECK(bus.Await([&] { return num_scans == 35; }));
  std::ofstream(position) << "00000000000000001000\n";
  const Ended other_log = folder.Run("laser_publisher", arguments);
  CHECK(other_log.exit_code == 1);
  CHECK(other_log.errors.find("the log has 30 scans, but 1000 of it were published before") != std::string::npos);
  std::ofstream(position) << "nothing\n";
  folder.CheckRefused("laser_publisher", arguments, "--position " + position + ": holds no number of scans", 1);
}

TEST_CASE("run_stack --part-bytes makes smaller messages of the same map") {
  const TemporaryFolder folder;
  const std::string log = WriteMapped(folder, TakeScans("sim:demo", 60, 8));
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  std::size_t largest_bytes = 0;
  std::int32_t most_parts = 0;
  bus->Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t& delta) {
    most_parts = std::max(most_parts, delta.num_parts);
    if (delta.num_tiles > 1) largest_bytes = std::max(largest_bytes, Encode(delta).size());  // a tile stays whole
  });
  Process run_stack = folder.StartStack(log, "out", url, {"--part-bytes", "1400"});
  CHECK(bus.Await([&] { return !run_stack.IsRunning(); }));
  CHECK(run_stack.AwaitExit() == 0);
  CHECK(most_parts > 2);
  CHECK(largest_bytes > 700);
  CHECK(largest_bytes <= 1400);
  folder.CheckSame("out", "offline");
}

TEST_CASE("two stacks on one bus with channel prefixes of their own do not disturb each other") {
  const TemporaryFolder folder;
  const std::string log_1 = WriteMapped(folder, TakeScans("sim:demo", 150, 4), {}, "offline_1");
  const std::string log_2 = WriteMapped(folder, TakeScans("sim:corridor", 150, 4), {}, "offline_2");
  const std::string url = MakeBusUrl();
  Stack robot_1({url, folder / "out_1", {"--channel-prefix", "robot1/"}});
  Stack robot_2({url, folder / "out_2", {"--channel-prefix", "robot1"}});  // as similar as can be
  REQUIRE(robot_1.StartServices());
  REQUIRE(robot_2.StartServices());
  REQUIRE(robot_1.StartPublisher(log_1, "max"));
  REQUIRE(robot_2.StartPublisher(log_2, "max"));
  CHECK(robot_1.Finish());
  CHECK(robot_2.Finish());
  folder.CheckSame("out_1", "offline_1");
  folder.CheckSame("out_2", "offline_2");
  for (const char* file : {"out_1/summary.json", "out_2/summary.json"}) {
    CHECK(ReadFile(folder / file).find("malformed") == std::string::npos);
  }
}
