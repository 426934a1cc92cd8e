// Odometry: to the last bit the same in one process and in five, and never waited for in vain.

#include <fmt/core.h>

#include <chrono>
#include <fstream>
#include <mbot_lcm_msgs/pose2D_t.hpp>

#include "catch.hpp"
#include "common/math/random.hpp"
#include "faults.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/event_log_writer.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

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

}  // namespace

TEST_CASE(
    "with odometry an LCM log of a CARMEN log, and processes of which some are killed, give the files of one process") {
  const TemporaryFolder folder;
  const std::string log = WriteCarmenLog(folder / "run.clf", 1000);
  folder.Map(log, "offline");
  folder.Map(log, "without", {"--no-odometry"});
  CHECK(ReadFile(folder / "offline/trajectory.tum") != ReadFile(folder / "without/trajectory.tum"));
  const std::string converted = folder / "run.lcm";
  REQUIRE(folder.Run("laser_publisher", {log, "--lcm-url", "file://" + converted + "?mode=w"}).exit_code == 0);
  folder.Map(converted, "converted");
  folder.CheckSame("converted", "offline");
  MapAndKill(folder, {"odometry", log, {}}, "out",
             {{0.2, "rrhc_matcher"}, {0.4, "ray_selector"}, {0.6, "rrhc_matcher"}}, JournalBytes(folder / "offline"));
  folder.CheckSame("out", "offline");
}

TEST_CASE("a log whose scans turn against its odometry gives the map of the log whose scans do not, in all processes") {
  const TemporaryFolder folder;
  for (const bool is_mirrored : {false, true}) {
    EventLogWriter log((folder / (is_mirrored ? "mirrored.lcm" : "right.lcm")).string());
    const auto source = OpenLaserSource("sim:demo", {1});
    for (int k = 0; k < 300; ++k) {
      const LaserScan scan = source->Next().value();
      log.Write(kOdometryChannel, ToMessage(Odometry{scan.utime, RoundOdometry(source->TruePose().value())}));
      log.Write(kLaserChannel, ToMessage(is_mirrored ? Mirror(scan) : scan));
    }
    log.Flush();
  }
  const std::string mirrored = folder / "mirrored.lcm";
  folder.Map(folder / "right.lcm", "right");
  const Ended ended = folder.Map(mirrored, "mirrored");
  CHECK(ended.errors.find("; the scans turn in the opposite direction to the odometry: they are turned round (") !=
        std::string::npos);
  folder.CheckSame("mirrored", "right");
  // A configuration file would tell each process to turn them round.
  std::ofstream(folder / "mirrored.toml") << "mirrored = true\n";
  folder.MapWithStack(mirrored, "out");
  folder.CheckSame("out", "right");
  folder.MapWithStack(mirrored, "configured", {"--config", folder / "mirrored.toml"});
  folder.CheckSame("configured", "right");
  // The earlier scans are known again.
  const Ended resumed = folder.MapWithStack(mirrored, "out", {"--resume", folder / "out"});
  CHECK(resumed.errors.find("other scans of the same times") == std::string::npos);
  folder.CheckSame("out", "right");
  // Who insists is told.
  const Ended insists = folder.Map(mirrored, "insists", {"--no-mirrored"});
  CHECK(insists.errors.find("the scans turn in the opposite direction to the odometry: remove --no-mirrored") !=
        std::string::npos);
}

TEST_CASE("laser_publisher sends the odometry of a scan before each sending of the scan, unless it is turned off") {
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
    if (!with_odometry) flags.push_back("--no-odometry");
    Process publisher("laser_publisher", flags, folder / "log");
    REQUIRE(bus.Await([&] { return num_scans >= 4; }));  // nobody maps: the first scan again and again
    CHECK(publisher.Interrupt() == 0);
    CHECK(in_order);
    CHECK(odometry.empty() != with_odometry);
    for (const Odometry& sent : odometry) CHECK(sent.T_odom_robot == odometry.front().T_odom_robot);
  }
}

TEST_CASE("a matcher in lockstep waits for the odometry of a scan") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 1);
  for (const std::string run : {"lockstep", "mbot"}) {
    CAPTURE(run);
    const std::string url = MakeBusUrl();
    Stack stack({url, folder / run});
    REQUIRE(stack.StartServices());
    TestBus bus(url);
    int num_matches = 0;
    bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t& match) {
      ++num_matches;
      CHECK(match.has_odometry == 1);
    });
    bus->Publish(kLaserChannel, ToMessage(scans[0]));
    REQUIRE(bus.Await([&] { return bus.Count("rrhc_matcher.odometry_awaited") == 1; }));
    CHECK(num_matches == 0);
    if (run == "mbot") {
      bus->Publish(kOdometryChannel, mbot_lcm_msgs::pose2D_t{scans[0].utime, 1.0f, 2.0f, 3.0f});
    } else {
      bus->Publish(kOdometryChannel, ToMessage(Odometry{scans[0].utime, Pose2{1.0, 2.0, 3.0}}));
    }
    bus->Publish(kLaserChannel, ToMessage(scans[0]));
    CHECK(bus.Await([&] { return num_matches == 1; }));
    CHECK(stack.Finish());
  }
}

TEST_CASE("live, no scan waits for odometry that nobody sends; what comes and ceases is waited for once, in vain") {
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 3);
  const std::string url = MakeBusUrl();
  constexpr double kWait_s = 2.0;
  Stack stack({.url = url,
               .out = folder / "out",
               .lockstep = false,
               .own_flags = {{"rrhc_matcher", {"--map-wait-s", fmt::format("{}", kWait_s)}}}});
  REQUIRE(stack.StartServices());
  TestBus bus(url);
  int num_matches = 0;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t&) { ++num_matches; });
  const auto SecondsToMatch = [&](const LaserScan& scan) {
    const auto begin = std::chrono::steady_clock::now();
    const int before = num_matches;
    bus->Publish(kLaserChannel, ToMessage(scan));
    REQUIRE(bus.Await([&] { return num_matches > before; }));
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  CHECK(SecondsToMatch(scans[0]) < kWait_s);
  CHECK(bus.Count("rrhc_matcher.odometry_missing") == 0);
  bus->Publish(kOdometryChannel, ToMessage(Odometry{scans[1].utime - 1000, Pose2{1.0, 2.0, 3.0}}));
  CHECK(SecondsToMatch(scans[1]) >= kWait_s);
  CHECK(SecondsToMatch(scans[2]) < kWait_s);
  CHECK(bus.Await([&] { return bus.Count("rrhc_matcher.odometry_missing") == 1; }));
  CHECK(stack.Finish());
}
