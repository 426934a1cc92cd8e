// Which odometry is used, and what the programs say of it.

#include <array>
#include <fstream>

#include "catch.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::string kTfBag = CRSM_SOURCE_DIR "/tests/bags/data/tf.bag";
const std::string kOdomBag = CRSM_SOURCE_DIR "/tests/bags/data/lz4.bag";
const std::string kMounting = "the laser stands at x 0.250 m, y -0.100 m, yaw 90.0 deg on the robot\n";

void CheckSays(const Ended& ended, const std::string& line) {
  INFO(ended.errors);
  CHECK(ended.exit_code == 0);
  CHECK(ended.errors.find(line) != std::string::npos);
}

}  // namespace

TEST_CASE("slam_offline tells at its start which odometry it uses, or does not, and at its end what had it") {
  const TemporaryFolder folder;
  auto Map = [&, number = 0](const std::string& log, const std::vector<std::string>& flags) mutable {
    return folder.Map(log, std::to_string(number++), flags);
  };
  const std::string tf = "slam_offline: " + kTfBag;
  const std::string odom = "slam_offline: " + kOdomBag;
  const Ended without = Map(kTfBag, {"--no-odometry"});
  CheckSays(without, "; its odometry (base_link in the frame odom of TF) is not used\n");
  CHECK(without.errors.find(" gives odometry to ") == std::string::npos);
  CheckSays(Map(kTfBag, {}), "; its odometry (base_link in the frame odom of TF) is used\n");
  CheckSays(Map(kTfBag, {}), tf + " gives odometry to 3 of 3 scans (base_link in the frame odom of TF): " + kMounting);
  CheckSays(Map(kOdomBag, {}), "; its odometry (/odom) is used\n");
  CheckSays(Map(kOdomBag, {"--odometry-topic", "/odom"}),
            odom +
                " gives odometry to 3 of 3 scans (/odom): where the laser stands on the robot is not known, as the "
                "bag has no TF\n");
  CheckSays(Map("sim:" CRSM_SOURCE_DIR "/tests/bags/small.world", {}), "; its first scans have no odometry\n");
}

TEST_CASE("laser_publisher and run_stack tell the same") {
  const TemporaryFolder folder;
  const std::string url = "file://" + (folder / "converted.lcm").string() + "?mode=w";
  CheckSays(folder.Run("laser_publisher", {kTfBag, "--lcm-url", url}), kMounting);
  CheckSays(folder.Map(folder / "converted.lcm", "out"), "; its odometry (ODOMETRY) is used\n");
  CheckSays(folder.MapWithStack(kTfBag, "stack"), "; its odometry (base_link in the frame odom of TF) is used\n");
  CheckSays(folder.MapWithStack(kTfBag, "stack2", {"--odometry-topic", "odom"}), kMounting);
}

TEST_CASE("odometry that is named and not there is refused in a line, before anything is done") {
  const TemporaryFolder folder;
  const std::string there =
      " has no odometry /wheels; its topics of odometry: /odom (nav_msgs/Odometry in ros1); it has ";
  const std::string out = folder / "out";
  const std::string carmen = folder / "run.clf";
  std::ofstream(carmen) << "FLASER 3 1 1 1 0 0 0 0 0 0 1.5 host 7.5\n";
  const std::string flag = "--odometry-topic /odom: ";
  for (const auto& [log, topic, expected] : std::vector<std::array<std::string, 3>>{
           {kOdomBag, "/wheels", kOdomBag + there},
           {"sim:demo", "/odom", flag + "a simulated world has its odometry in its line 'wheels'; remove it"},
           {"hokuyo:/dev/ttyACM9", "/odom", flag + "a laser has no odometry; remove it"},
           {carmen, "/odom", flag + carmen + " is a CARMEN log, which has its odometry in the lines of the laser"}}) {
    folder.CheckRefused("slam_offline", {log, "--odometry-topic", topic, "--out", out}, expected, 1);
  }
  folder.CheckRefused("laser_publisher", {kOdomBag, "--odometry-topic", "/wheels"}, kOdomBag + there, 1);
  folder.CheckRefused("run_stack", {kOdomBag, "--out", out, "--odometry-topic", "/wheels"}, kOdomBag + there, 1);
  CHECK_FALSE(fs::exists(out));
}

TEST_CASE("a matcher takes the odometry of the channel that is named") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  std::ofstream(folder / "topic.toml") << "odometry_topic = \"WHEELS\"\n";
  Stack stack({url, folder / "out", {"--config", folder / "topic.toml"}});
  REQUIRE(stack.StartServices());
  TestBus bus(url);
  const LaserScan scan = TakeScans("sim:demo", 1).at(0);
  std::optional<scan_match_t> match;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t& message) { match = message; });
  bus->Publish("WHEELS", ToMessage(Odometry{scan.utime, Pose2{1.0, 2.0, 3.0}}));
  bus->Publish(kLaserChannel, ToMessage(scan));
  REQUIRE(bus.Await([&] { return match.has_value(); }));
  CHECK(match->has_odometry == 1);
  CHECK(match->odometry_x_m == 1.0);
  CHECK(stack.Finish());
}
