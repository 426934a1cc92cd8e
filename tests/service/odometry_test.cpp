// Odometry, when it is on: to the last bit the same in one process and in five, and never waited for in vain.

#include <fmt/core.h>

#include <fstream>
#include <mbot_lcm_msgs/pose2D_t.hpp>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "processes.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kMapFiles{"map.png", "map.yaml", "trajectory.tum"};

/// A CARMEN log of the demo world, every second scan of it: odometry drifts, is upside down for a while, jumps once,
/// and is missing from some lines.
fs::path WriteCarmenLog(const fs::path& path, int num_scans) {
  const auto source = OpenLaserSource("sim:demo", {1});
  std::ofstream log(path);
  Random noise(7);
  Pose2 T_map_last;
  Pose2 odometry{10.0, -3.0, 2.0};
  for (int k = 0; k < num_scans; ++k) {
    source->Next();
    const LaserScan scan = source->Next().value();
    const Pose2 T_map_laser = source->TruePose().value();
    Pose2 motion = Inverse(T_map_last) * T_map_laser;
    T_map_last = T_map_laser;
    motion.x_m = motion.x_m * 1.02 * (k / 40 == 2 ? -1.0 : 1.0) + (k == 150 ? 30.0 : 0.0);
    motion.yaw_rad += noise.Uniform(-0.01, 0.01);
    odometry = odometry * motion;

    log << fmt::format("ROBOTLASER1 0 {} 4.7 {} 30 0.01 0 {}", scan.angle_min_rad, scan.angle_step_rad,
                       scan.ranges_m.size());
    for (const float range_m : scan.ranges_m) log << fmt::format(" {}", range_m);
    const std::string pose =
        k % 60 == 7 ? "nan 0 0" : fmt::format("{:.6f} {:.6f} {:.6f}", odometry.x_m, odometry.y_m, odometry.yaw_rad);
    log << fmt::format(" 0 0 0 0 {} 0 0 0 0 0 {}.{:06} host 1.0\n", pose, scan.utime / 1'000'000,
                       scan.utime % 1'000'000);
  }
  return path;
}

fs::path WriteConfig(const fs::path& path) {
  std::ofstream(path) << "odometry = true\n";
  return path;
}

void MapOffline(const fs::path& log, const fs::path& out, const std::vector<std::string>& flags) {
  std::vector<std::string> arguments{log.string(), "--out", out.string()};
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  REQUIRE(Run("slam_offline", arguments, out.string() + "_log") == 0);
}

void CheckSameFiles(const fs::path& folder, const fs::path& expected) {
  for (const std::string& file : kMapFiles) {
    INFO(file);
    const std::string content = ReadFile(folder / file);
    CHECK_FALSE(content.empty());
    CHECK(content == ReadFile(expected / file));
  }
}

}  // namespace

TEST_CASE("with odometry five processes make the files that one process makes, also when they are killed on the way") {
  const TemporaryFolder folder;
  const fs::path log = WriteCarmenLog(folder / "run.clf", 300);
  MapOffline(log, folder / "offline", {"--odometry"});
  MapOffline(log, folder / "without", {});
  CHECK(ReadFile(folder / "offline/trajectory.tum") != ReadFile(folder / "without/trajectory.tum"));

  const std::string url = MakeBusUrl();
  MapWatcher watcher(url);
  Stack stack({url, folder / "out", {"--config", WriteConfig(folder / "odometry.toml")}});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(log.string(), "max"));
  std::int64_t version = 0;
  for (const std::string service : {"rrhc_matcher", "ray_selector", "rrhc_matcher"}) {
    REQUIRE(watcher.AwaitVersion(version += 60));
    INFO(service);
    CHECK(stack.Start(service));
  }
  CHECK(stack.Finish());
  CheckSameFiles(folder / "out", folder / "offline");
}

TEST_CASE("run_stack --odometry makes the files of slam_offline --odometry") {
  const TemporaryFolder folder;
  const fs::path log = WriteCarmenLog(folder / "run.clf", 100);
  MapOffline(log, folder / "offline", {"--odometry"});
  CHECK(Run(CRSM_SOURCE_DIR "/scripts/run_stack",
            {log.string(), "--out", folder / "out", "--odometry", "--lcm-url", MakeBusUrl()}, folder / "log") == 0);
  CheckSameFiles(folder / "out", folder / "offline");
}

TEST_CASE("a CARMEN log that becomes an LCM log keeps its odometry to the last bit when that is asked for") {
  const TemporaryFolder folder;
  const fs::path log = WriteCarmenLog(folder / "run.clf", 200);
  const fs::path converted = folder / "run.lcm";
  REQUIRE(Run("laser_publisher", {log.string(), "--odometry", "--lcm-url", "file://" + converted.string() + "?mode=w"},
              folder / "log") == 0);
  MapOffline(log, folder / "from_carmen", {"--odometry"});
  MapOffline(converted, folder / "from_lcm", {"--odometry"});
  CheckSameFiles(folder / "from_lcm", folder / "from_carmen");
}

TEST_CASE("laser_publisher sends the odometry of a scan before each sending of the scan, and none unless asked") {
  const TemporaryFolder folder;
  const fs::path log = WriteCarmenLog(folder / "run.clf", 20);
  for (const bool with_odometry : {true, false}) {
    const std::string url = MakeBusUrl();
    TestBus bus(url);
    std::vector<Odometry> odometry;
    int num_scans = 0;
    bool in_order = true;
    bus->Subscribe<bot_core::pose_t>(kOdometryChannel,
                                     [&](const auto& pose) { odometry.push_back(FromMessage(pose)); });
    bus->Subscribe<bot_core::planar_lidar_t>(kLaserChannel, [&](const auto& laser) {
      ++num_scans;
      if (with_odometry) in_order = in_order && !odometry.empty() && odometry.back().utime == laser.utime;
    });
    std::vector<std::string> flags{log.string(), "--lcm-url", url, "--rate", "max", "--resend-s", "0.02"};
    if (with_odometry) flags.push_back("--odometry");
    Process publisher("laser_publisher", flags, folder / "log");
    REQUIRE(bus.Await([&] { return num_scans >= 4; }));  // nobody maps: the first scan again and again
    CHECK(publisher.Interrupt() == 0);
    CHECK(in_order);
    CHECK(odometry.empty() != with_odometry);
    for (const Odometry& sent : odometry) CHECK(sent.T_odom_robot == odometry.front().T_odom_robot);
  }
}

TEST_CASE("a matcher in lockstep waits for the odometry of a scan; one that runs live goes on without it") {
  const TemporaryFolder folder;
  const std::vector<std::string> flags{"--config", WriteConfig(folder / "odometry.toml")};
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 2);
  for (const std::string run : {"lockstep", "mbot", "live"}) {
    CAPTURE(run);
    const bool lockstep = run != "live";
    const std::string url = MakeBusUrl();
    Stack stack({url, folder / run, flags, lockstep});
    REQUIRE(stack.StartServices());
    TestBus bus(url);
    int num_matches = 0;
    std::map<std::string, std::int64_t> counts;
    bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t& match) {
      ++num_matches;
      CHECK(match.has_odometry == (lockstep ? 1 : 0));
    });
    bus->Subscribe<service_status_t>(kEveryServiceStatus, [&](const service_status_t& status) {
      for (std::size_t i = 0; i < status.counter_name.size(); ++i) {
        counts[status.name + "." + status.counter_name[i]] = status.counter_value[i];
      }
    });
    bus->Publish(kLaserChannel, ToMessage(scans[0]));
    if (lockstep) {
      REQUIRE(bus.Await([&] { return counts["rrhc_matcher.odometry_awaited"] == 1; }));
      CHECK(num_matches == 0);
      if (run == "mbot") {
        bus->Publish(kOdometryChannel, mbot_lcm_msgs::pose2D_t{scans[0].utime, 1.0f, 2.0f, 3.0f});
      } else {
        bus->Publish(kOdometryChannel, ToMessage(Odometry{scans[0].utime, Pose2{1.0, 2.0, 3.0}}));
      }
      bus->Publish(kLaserChannel, ToMessage(scans[0]));
    } else {
      REQUIRE(bus.Await([&] { return counts["rrhc_matcher.odometry_missing"] == 1; }));
    }
    CHECK(bus.Await([&] { return num_matches == 1; }));
    CHECK(stack.Finish());
  }
}
