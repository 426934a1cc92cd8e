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

const std::vector<std::string> kMapFiles{"map.png", "map.yaml", "trajectory.tum"};

void CheckSameFiles(const fs::path& folder, const fs::path& expected, const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    INFO(file);
    const std::string content = ReadFile(folder / file);
    CHECK_FALSE(content.empty());
    CHECK(content == ReadFile(expected / file));
  }
}

/// Maps scans in one process. Returns the folder of the results.
fs::path MapOffline(const std::vector<LaserScan>& scans, const fs::path& folder, std::vector<std::string> flags = {}) {
  fs::create_directories(folder);
  WriteScans(scans, folder / "run.lcm");
  flags.insert(flags.end(), {(folder / "run.lcm").string(), "--out", folder.string()});
  REQUIRE(Run("slam_offline", flags, folder / "log") == 0);
  return folder;
}

const std::string kRunStack = CRSM_SOURCE_DIR "/scripts/run_stack";

/// The number of the child process with this name; fails where there is none.
pid_t FindChild(pid_t parent, const std::string& name) {
  std::ifstream children("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
  for (pid_t pid = 0; children >> pid;) {
    if (ReadFile("/proc/" + std::to_string(pid) + "/comm") == name.substr(0, 15) + "\n") return pid;
  }
  FAIL("there is no " << name);
  return 0;
}

int CountOf(const std::string& wanted, const std::string& text) {
  int count = 0;
  for (auto at = text.find(wanted); at != std::string::npos; at = text.find(wanted, at + 1)) ++count;
  return count;
}

std::size_t CountLines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("five processes in lockstep make the files that one process makes, in each profile") {
  for (const std::string profile : {"default", "paper"}) {
    INFO(profile);
    const TemporaryFolder folder;
    const fs::path offline = MapOffline(TakeScans("sim:demo", 250, 2), folder / "offline", {"--profile", profile});
    const fs::path out = folder / "out";
    CHECK(Run(kRunStack,
              {(offline / "run.lcm").string(), "--out", out.string(), "--profile", profile, "--lcm-url", MakeBusUrl()},
              folder / "log") == 0);
    CheckSameFiles(out, offline, {"map.png", "map.yaml", "trajectory.tum", "overview.png"});
    CHECK(CountLines(ReadFile(out / "trajectory.tum")) == 250);
  }
}

TEST_CASE("slam_offline takes what the services are told of their bus, and what it maps is the same") {
  const TemporaryFolder folder;
  std::ofstream(folder / "all.toml") << "seed = 3\nlcm_url = \"tcpq://localhost\"\nchannel_prefix = \"robot1/\"\n"
                                        "rate = \"max\"\nlockstep = true\nexport_period_s = 2.0\n";
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 50);
  const fs::path alone = MapOffline(scans, folder / "alone", {"--seed", "3"});
  const fs::path shared =
      MapOffline(scans, folder / "shared",
                 {"--config", folder / "all.toml", "--lcm-url", MakeBusUrl(), "--channel-prefix", "robot2/"});
  CheckSameFiles(shared, alone, kMapFiles);
}

TEST_CASE("five processes in lockstep make the files that one process makes from a real log", "[logs]") {
  const auto log = FindRealLog("radish/fr079.clf.gz");
  if (!log) return;
  const TemporaryFolder folder;
  const fs::path offline = MapOffline(TakeScans(*log, 400), folder / "offline", {"--preset", "sick"});
  Stack stack({MakeBusUrl(), folder / "out", {"--preset", "sick"}});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher((offline / "run.lcm").string(), "max"));
  CHECK(stack.Finish());
  CheckSameFiles(folder / "out", offline, {"map.png", "map.yaml", "trajectory.tum", "overview.png"});
}

TEST_CASE(
    "a log that lcm-logplayer plays into the running services gives the map of lockstep, and no scan is dropped") {
  const TemporaryFolder folder;
  if (Run("/usr/bin/env", {"which", "lcm-logplayer"}, folder / "log") != 0) {
    WARN("skipped: lcm-logplayer is not installed");
    return;
  }
  // A light search and a patient matcher: what a slow machine makes of the time is no concern of this test.
  std::ofstream(folder / "light.toml") << "num_evaluations = 200\nmap_wait_s = 60.0\n";
  const std::vector<std::string> flags{"--config", folder / "light.toml"};
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 40);  // 10 Hz, 4 s
  const fs::path offline = MapOffline(scans, folder / "offline", flags);
  const std::string converted = folder / "converted.lcm";
  REQUIRE(Run("laser_publisher", {(offline / "run.lcm").string(), "--lcm-url", "file://" + converted + "?mode=w"},
              folder / "log") == 0);
  CHECK(ReadFile(converted) == ReadFile(offline / "run.lcm"));

  for (const std::string speed : {"1", "4"}) {
    INFO("speed " << speed);
    const std::string url = MakeBusUrl();
    const fs::path out = folder / ("out" + speed);
    Stack stack({url, out, flags, false});
    REQUIRE(stack.StartServices());
    MapWatcher watcher(url);
    CHECK(Run("/usr/bin/env", {"lcm-logplayer", "-s", speed, "-l", url, converted}, folder / "log") == 0);
    CHECK(watcher.AwaitScan(scans.back().utime));
    CHECK(stack.Finish());
    CheckSameFiles(out, offline, kMapFiles);
    CHECK(ReadFile(out / "summary.json").find("dropped") == std::string::npos);
  }
}

TEST_CASE("a scan whose rays all measured nothing is answered, counted, and leaves no trace on the map") {
  std::vector<LaserScan> scans = TakeScans("sim:demo", 20, 4);
  for (std::size_t i = 0; i < scans[10].ranges_m.size(); ++i) {
    scans[10].ranges_m[i] = i % 2 ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
  }
  const TemporaryFolder folder;
  const fs::path offline = MapOffline(scans, folder / "offline");
  const std::string url = MakeBusUrl();
  Stack stack({url, folder / "out", {}});
  REQUIRE(stack.StartServices());
  TestBus bus(url);
  std::map<std::string, std::int64_t> counts;
  bus->Subscribe<service_status_t>(kEveryServiceStatus, [&](const service_status_t& status) {
    for (std::size_t i = 0; i < status.counter_name.size(); ++i) {
      counts[status.name + "." + status.counter_name[i]] = status.counter_value[i];
    }
  });
  REQUIRE(stack.StartPublisher((offline / "run.lcm").string(), "max"));
  CHECK(bus.Await([&] { return counts["ray_selector.handled"] == 20; }));
  CHECK(bus.Await([&] { return counts["rrhc_matcher.handled"] == 20; }));
  CHECK(counts["ray_selector.scan_without_rays"] == 1);
  CHECK(counts["rrhc_matcher.lost"] == 1);
  CHECK(stack.Finish());
  CheckSameFiles(folder / "out", offline, kMapFiles);
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

TEST_CASE("an exporter that starts in the middle of a run gets the whole map") {
  const TemporaryFolder folder;
  const fs::path offline = MapOffline(TakeScans("sim:demo", 300, 2), folder / "offline");
  const std::string url = MakeBusUrl();
  MapWatcher watcher(url);
  Stack stack({url, folder / "out", {}});
  REQUIRE((stack.Start("map_updater") && stack.Start("loop_closer") && stack.Start("rrhc_matcher") &&
           stack.Start("ray_selector")));
  REQUIRE(stack.StartPublisher((offline / "run.lcm").string(), "max"));
  REQUIRE(watcher.AwaitVersion(100));
  REQUIRE(stack.Start("map_exporter"));
  CHECK(stack.Finish());
  CheckSameFiles(folder / "out", offline, kMapFiles);
}

TEST_CASE("matcher, selector and exporter that are killed and started anew in the middle of a run change nothing") {
  const TemporaryFolder folder;
  const fs::path offline = MapOffline(TakeScans("sim:demo", 400, 2), folder / "offline");
  const std::string url = MakeBusUrl();
  MapWatcher watcher(url);
  Stack stack({url, folder / "out", {}});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher((offline / "run.lcm").string(), "max"));
  std::int64_t version = 0;
  for (const std::string service : {"rrhc_matcher", "ray_selector", "map_exporter", "rrhc_matcher"}) {
    REQUIRE(watcher.AwaitVersion(version += 60));
    INFO(service);
    CHECK(stack.Start(service));
  }
  CHECK(stack.Finish());
  CheckSameFiles(folder / "out", offline, kMapFiles);
}

TEST_CASE("Ctrl-C in the middle of run_stack leaves all files, and the map of the scans that the trajectory has") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 3000);
  WriteScans(scans, folder / "run.lcm");
  const std::string url = MakeBusUrl();
  MapWatcher watcher(url);
  const fs::path out = folder / "out";
  Process run_stack(kRunStack, {folder / "run.lcm", "--out", out.string(), "--lcm-url", url}, folder / "log");
  REQUIRE(watcher.AwaitVersion(150));
  CHECK(run_stack.Interrupt() == 0);

  const std::size_t num_mapped = CountLines(ReadFile(out / "trajectory.tum"));
  INFO(run_stack.errors());
  REQUIRE(num_mapped >= 150);
  REQUIRE(num_mapped < scans.size());
  const fs::path offline =
      MapOffline({scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(num_mapped)}, folder / "offline");
  CheckSameFiles(out, offline, kMapFiles);
  CHECK(fs::file_size(out / "overview.png") > 0);
  CHECK(ReadFile(out / "summary.json").find("\"scans\": " + std::to_string(num_mapped) + ",") != std::string::npos);
}

TEST_CASE("run_stack survives the death of its publisher: nothing is lost, nothing doubled, same files") {
  const TemporaryFolder folder;
  const fs::path offline = MapOffline(TakeScans("sim:demo", 1500), folder / "offline");
  const std::string url = MakeBusUrl();
  MapWatcher watcher(url);
  const fs::path out = folder / "out";
  Process run_stack(kRunStack, {offline / "run.lcm", "--out", out.string(), "--lcm-url", url}, folder / "log");
  for (const std::int64_t version : {100, 400, 700}) {
    REQUIRE(watcher.AwaitVersion(version));
    kill(FindChild(run_stack.pid(), "laser_publisher"), SIGKILL);
  }
  CHECK(run_stack.AwaitExit() == 0);
  INFO(run_stack.errors());
  CHECK(CountOf("laser_publisher ended unexpectedly (signal 9): restarted", run_stack.errors()) == 3);
  CHECK(run_stack.errors().find("laser_publisher: continues after") != std::string::npos);
  CheckSameFiles(out, offline, kMapFiles);
  CHECK(ReadFile(out / "summary.json").find("\"scans\": 1500,") != std::string::npos);
}

TEST_CASE("laser_publisher goes on where its --position says, and refuses one that says nothing") {
  const TemporaryFolder folder;
  WriteScans(TakeScans("sim:demo", 30), folder / "run.lcm");
  const std::string position = folder / "position";
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  int num_scans = 0;
  bus->Subscribe<bot_core::planar_lidar_t>(kLaserChannel, [&](const auto&) { ++num_scans; });
  const std::vector<std::string> arguments{folder / "run.lcm", "--rate", "1000", "--lcm-url", url,
                                           "--position",       position};
  REQUIRE(Run("laser_publisher", arguments, folder / "log") == 0);
  CHECK(bus.Await([&] { return num_scans == 30; }));
  CHECK(ReadFile(position) == "00000000000000000030\n");
  std::ofstream(position) << "00000000000000000025\n";
  REQUIRE(Run("laser_publisher", arguments, folder / "log") == 0);
  CHECK(bus.Await([&] { return num_scans == 35; }));
  std::ofstream(position) << "nothing\n";
  Process refused("laser_publisher", arguments, folder / "log");
  CHECK(refused.AwaitExit() == 1);
  CHECK(refused.errors() == "laser_publisher: --position " + position +
                                ": holds no number of scans; remove the file to start with the first scan\n");
}

TEST_CASE("run_stack --part-bytes makes smaller messages of the same map") {
  const TemporaryFolder folder;
  const fs::path offline = MapOffline(TakeScans("sim:demo", 60, 8), folder / "offline");
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  std::size_t largest_bytes = 0;
  std::int32_t most_parts = 0;
  bus->Subscribe<map_delta_t>(kMapDeltaChannel, [&](const map_delta_t& delta) {
    most_parts = std::max(most_parts, delta.num_parts);
    if (delta.num_tiles > 1) largest_bytes = std::max(largest_bytes, Encode(delta).size());  // a tile stays whole
  });
  const fs::path out = folder / "out";
  Process run_stack(kRunStack,
                    {(offline / "run.lcm").string(), "--out", out.string(), "--part-bytes", "1400", "--lcm-url", url},
                    folder / "log");
  CHECK(bus.Await([&] { return !run_stack.IsRunning(); }));
  CHECK(run_stack.AwaitExit() == 0);
  CHECK(most_parts > 2);
  CHECK(largest_bytes > 700);
  CHECK(largest_bytes <= 1400);
  CheckSameFiles(out, offline, kMapFiles);
}

TEST_CASE("two stacks on one bus with channel prefixes of their own do not disturb each other") {
  const TemporaryFolder folder;
  const fs::path offline_1 = MapOffline(TakeScans("sim:demo", 150, 4), folder / "offline_1");
  const fs::path offline_2 = MapOffline(TakeScans("sim:corridor", 150, 4), folder / "offline_2");
  const std::string url = MakeBusUrl();
  Stack robot_1({url, folder / "out_1", {"--channel-prefix", "robot1/"}});
  Stack robot_2({url, folder / "out_2", {"--channel-prefix", "robot1"}});  // as similar as can be
  REQUIRE(robot_1.StartServices());
  REQUIRE(robot_2.StartServices());
  REQUIRE(robot_1.StartPublisher((offline_1 / "run.lcm").string(), "max"));
  REQUIRE(robot_2.StartPublisher((offline_2 / "run.lcm").string(), "max"));
  CHECK(robot_1.Finish());
  CHECK(robot_2.Finish());
  CheckSameFiles(folder / "out_1", offline_1, kMapFiles);
  CheckSameFiles(folder / "out_2", offline_2, kMapFiles);
  for (const char* file : {"out_1/summary.json", "out_2/summary.json"}) {
    CHECK(ReadFile(folder / file).find("malformed") == std::string::npos);
  }
}
