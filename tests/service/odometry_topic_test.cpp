// Which odometry is used, and what the programs say of it.

#include <algorithm>
#include <fstream>

#include "catch.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"
#include "stand_ins.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::string kRunStack = CRSM_SOURCE_DIR "/scripts/run_stack";
const std::string kTfBag = CRSM_SOURCE_DIR "/tests/bags/data/tf.bag";
const std::string kOdomBag = CRSM_SOURCE_DIR "/tests/bags/data/lz4.bag";
const std::string kMounting = "the laser stands at x 0.250 m, y -0.100 m, yaw 90.0 deg on the robot\n";

struct Said {
  int exit_code = 0;
  std::string errors;
};

Said RunAndListen(const std::string& program, const std::vector<std::string>& words, const TemporaryFolder& folder) {
  Process process(program, words, folder / "log");
  const int exit_code = process.AwaitExit();
  return {exit_code, process.errors()};
}

Said MapOffline(const std::string& log, const std::vector<std::string>& flags) {
  const TemporaryFolder folder;
  std::vector<std::string> words{log, "--out", folder / "out"};
  words.insert(words.end(), flags.begin(), flags.end());
  return RunAndListen("slam_offline", words, folder);
}

void CheckSays(const Said& said, const std::string& line) {
  INFO(said.errors);
  CHECK(said.exit_code == 0);
  CHECK(said.errors.find(line) != std::string::npos);
}

void CheckRefused(const Said& said, const std::string& beginning) {
  INFO(said.errors);
  CHECK(said.exit_code == 1);
  CHECK(said.errors.starts_with(beginning));
  CHECK(std::count(said.errors.begin(), said.errors.end(), '\n') == 1);
}

}  // namespace

TEST_CASE("slam_offline tells of odometry that it does not use, and which it uses") {
  CheckSays(MapOffline(kTfBag, {}),
            "slam_offline: " + kTfBag + " has odometry (the frame odom of TF): --odometry uses it\n");
  CheckSays(
      MapOffline(kTfBag, {"--odometry"}),
      "slam_offline: " + kTfBag + " gives odometry to 3 of 3 scans (base_link in the frame odom of TF): " + kMounting);
  CheckSays(MapOffline(kOdomBag, {}), "slam_offline: " + kOdomBag + " has odometry (/odom): --odometry uses it\n");
  const Said named = MapOffline(kOdomBag, {"--odometry-topic", "/odom"});
  CheckSays(named, "slam_offline: " + kOdomBag +
                       " gives odometry to 3 of 3 scans (/odom): where the laser stands on the robot "
                       "is not known, as the bag has no TF\n");
  const Said simulated = MapOffline("sim:" CRSM_SOURCE_DIR "/tests/bags/small.world", {});
  CHECK(simulated.exit_code == 0);
  CHECK(simulated.errors.find("odometry") == std::string::npos);
}

TEST_CASE("laser_publisher and run_stack tell the same") {
  const TemporaryFolder folder;
  const std::string url = "file://" + (folder / "converted.lcm").string() + "?mode=w";
  CheckSays(RunAndListen("laser_publisher", {kTfBag, "--lcm-url", url}, folder),
            "laser_publisher: " + kTfBag + " has odometry (the frame odom of TF): --odometry uses it\n");
  CheckSays(RunAndListen("laser_publisher", {kTfBag, "--odometry", "--lcm-url", url}, folder), kMounting);
  CheckSays(RunAndListen("slam_offline", {folder / "converted.lcm", "--out", folder / "out"}, folder),
            "converted.lcm has odometry (ODOMETRY): --odometry uses it\n");
  CheckSays(RunAndListen(kRunStack, {kTfBag, "--out", folder / "stack", "--lcm-url", MakeBusUrl()}, folder),
            kTfBag + " has odometry (the frame odom of TF): --odometry uses it\n");
  CheckSays(
      RunAndListen(kRunStack,
                   {kTfBag, "--out", folder / "stack2", "--lcm-url", MakeBusUrl(), "--odometry-topic", "odom"}, folder),
      kMounting);
}

TEST_CASE("odometry that is named and not there is refused in a line, before anything is done") {
  const TemporaryFolder folder;
  const std::string there =
      " has no odometry /wheels; its topics of odometry: /odom (nav_msgs/Odometry in ros1); it has ";
  CheckRefused(MapOffline(kOdomBag, {"--odometry-topic", "/wheels"}), "slam_offline: " + kOdomBag + there);
  CheckRefused(RunAndListen("laser_publisher", {kOdomBag, "--odometry-topic", "/wheels"}, folder),
               "laser_publisher: " + kOdomBag + there);
  const fs::path out = folder / "out";
  CheckRefused(RunAndListen(kRunStack, {kOdomBag, "--out", out, "--odometry-topic", "/wheels"}, folder),
               "run_stack: " + kOdomBag + there);
  CHECK_FALSE(fs::exists(out));
  CheckRefused(
      MapOffline("sim:demo", {"--odometry-topic", "/odom"}),
      "slam_offline: --odometry-topic /odom: a simulated world has its odometry in its line 'wheels'; remove it");
  CheckRefused(MapOffline("hokuyo:/dev/ttyACM9", {"--odometry-topic", "/odom"}),
               "slam_offline: --odometry-topic /odom: a laser has no odometry; remove it");
  const fs::path carmen = folder / "run.clf";
  std::ofstream(carmen) << "FLASER 3 1 1 1 0 0 0 0 0 0 1.5 host 7.5\n";
  CheckRefused(MapOffline(carmen, {"--odometry-topic", "/odom"}),
               "slam_offline: --odometry-topic /odom: " + carmen.string() +
                   " is a CARMEN log, which has its odometry in the lines of the laser; remove it");
}

TEST_CASE("run_stack tells the matcher the channel of a live bus, and of a log that it comes on ODOMETRY") {
  StandIns live;
  live.Run("timeout --signal=INT 3 $run_stack live --out $out --odometry-topic WHEELS");
  INFO(live.output);
  CHECK(live.Event("rrhc_matcher") == "rrhc_matcher started --odometry-topic WHEELS --odometry");
  StandIns of_a_log;
  std::ofstream(of_a_log.Path("out.toml")) << "odometry_topic = \"/odom\"\n";
  of_a_log.Run("$run_stack " + kOdomBag + " --out $out --config $out.toml");
  INFO(of_a_log.output);
  CHECK(of_a_log.Event("rrhc_matcher") == "rrhc_matcher started --lockstep --odometry-topic ODOMETRY --config " +
                                              of_a_log.Path("out.toml") + " --odometry");
  StandIns by_flag;
  by_flag.Run("$run_stack " + kOdomBag + " --out $out --odometry-topic /odom");
  CHECK(by_flag.Event("rrhc_matcher") == "rrhc_matcher started --lockstep --odometry-topic ODOMETRY --odometry");
  CHECK(by_flag.Event("laser_publisher").ends_with(" --odometry-topic /odom --odometry"));
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
