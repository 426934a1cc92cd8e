// What is wrong with a live laser is said, in one line that names the mend, by the process that hears it.

#include <algorithm>
#include <cmath>
#include <sensor_msgs/LaserScan.hpp>
#include <thread>

#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "processes.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

/// A ray_selector, and a driver that talks to it.
class Driver {
 public:
  explicit Driver(std::vector<std::string> flags = {}, std::vector<LaserScan> scans = TakeScans("sim:demo", 60))
      : lcm_(url_), scans_(std::move(scans)), selector_("ray_selector", Complete(flags), folder_ / "log") {
    REQUIRE(selector_.AwaitReady());
  }

  /// What ray_selector says besides that it is ready, when it has said something while `publish` is called at 20 Hz.
  template <class Publish>
  std::string AwaitComplaint(Publish publish) {
    WaitUntil(
        [&] {
          publish();
          return !Complaints().empty();
        },
        std::chrono::milliseconds(50));
    return Complaints();
  }
  std::string AwaitComplaint() {
    return AwaitComplaint([] {});
  }

  /// The next scan, changed.
  template <class Change>
  void Publish(const std::string& channel, Change change) {
    bot_core::planar_lidar_t message = ToMessage(scans_[next_++ % scans_.size()]);
    change(message);
    lcm_.publish(channel, &message);
  }
  void PublishGood(const std::string& channel) {
    Publish(channel, [](auto&) {});
  }
  /// The last one.
  void PublishAgain(const std::string& channel) {
    --next_;
    PublishGood(channel);
  }

  std::string Complaints() const {
    const std::string ready = "ray_selector: ready\n";
    const std::string said = selector_.errors();
    return said.substr(std::min(said.size(), ready.size()));
  }

  const std::string& url() const { return url_; }
  lcm::LCM& lcm() { return lcm_; }

 private:
  std::vector<std::string> Complete(std::vector<std::string> flags) const {
    flags.insert(flags.end(), {"--lcm-url", url_});
    return flags;
  }

  TemporaryFolder folder_;
  std::string url_ = MakeBusUrl();
  lcm::LCM lcm_;
  std::vector<LaserScan> scans_;
  std::size_t next_ = 0;
  Process selector_;
};

void CheckLine(const std::string& said, const std::string& beginning, const std::vector<std::string>& parts) {
  CAPTURE(said);
  CHECK(said.rfind("ray_selector: " + beginning, 0) == 0);
  for (const std::string& part : parts) {
    CAPTURE(part);
    CHECK(said.find(part) != std::string::npos);
  }
  CHECK(std::count(said.begin(), said.end(), '\n') == 1);
}

}  // namespace

TEST_CASE("what is wrong with the messages of a driver is said in one line that names the mend") {
  const bot_core::pose_t pose{5, {}, {}, {1.0, 0.0, 0.0, 0.0}, {}, {}};
  const std::vector<std::uint8_t> unknown{1, 2, 3, 4, 5, 6, 7, 8, 9};
  int num_messages = 0;
  std::int64_t utime_ms = 1'700'000'000'000;
  const auto Changed = [](auto change) { return [=](Driver& driver) { driver.Publish("LASER", change); }; };
  struct Case {
    std::function<void(Driver&)> publish;
    std::string said;
    std::vector<std::string> also = {};
    std::vector<std::string> flags = {};
  };
  for (const Case& wrong :
       std::vector<Case>{{[&](Driver& driver) {
                            driver.PublishGood("robot1/LASER");
                            driver.lcm().publish("GPS", &pose);
                            driver.lcm().publish("CAMERA", unknown.data(), static_cast<unsigned>(unknown.size()));
                          },
                          "LASER: nothing came since the start; this bus has ",
                          {"CAMERA (a type with fingerprint 0x0102030405060708)", "GPS (bot_core.pose_t)",
                           "robot1/LASER (bot_core.planar_lidar_t)", "--channel-prefix \"robot1/\"?"}},
                         {[&](Driver& driver) { driver.lcm().publish("LCM_SELF_TEST", "lcm self test", 13); },
                          "robot7/LASER: nothing came since the start; no other channel is on this bus",
                          {"does the laser's driver run"},
                          {"--channel-prefix", "robot7/"}},
                         {[&](Driver& driver) { driver.lcm().publish("LASER", &pose); },
                          "LASER: 3 of the last 3 messages are left out: messages are bot_core.pose_t",
                          {"bot_core.planar_lidar_t"}},
                         {Changed([](auto& scan) { scan.rad0 = -120.0f, scan.radstep = 0.36f; }),
                          "LASER: 3 of the last 3 messages are left out: angles look like degrees"},
                         {Changed([](auto& scan) {
                            for (float& range : scan.ranges) range *= 1000.0f;
                          }),
                          "LASER: ranges look like millimetres"},
                         {Changed([](auto& scan) { scan.utime = 0; }), "LASER: utime is always 0"},
                         {Changed([&](auto& scan) { scan.utime = utime_ms += 50; }),
                          "LASER: utime is in milliseconds, as 17",
                          {"times are 1,000 times too small", "the driver must set utime in microseconds"}},
                         {Changed([](auto& scan) {
                            for (float& range : scan.ranges) range += 50.0f;
                          }),
                          "LASER: none of the "},
                         {Changed([&](auto& scan) {
                            if (++num_messages % 2 == 0) scan.ranges.resize(1), scan.nranges = 1;
                          }),
                          "LASER: 3 of the last 6 messages are left out: scans have 1 rays"}}) {
    Driver driver(wrong.flags);
    CheckLine(driver.AwaitComplaint([&] { wrong.publish(driver); }), wrong.said, wrong.also);
  }
}

TEST_CASE("a laser whose beams are measured in the other order than the flags say is told so while it runs") {
  Driver driver({"--preset", "rplidar-a1", "--sweep-s", "-0.15"}, TakeScans("sim:arena", 340));
  for (int i = 0; i < 340; ++i) {
    driver.PublishGood("LASER");
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  CheckLine(driver.AwaitComplaint([&] { driver.PublishAgain("LASER"); }),
            "LASER: each scan takes 0.15 s, counter-clockwise, not as is said (0.15 s, clockwise): ",
            {"--no-beam-times --sweep-s 0.15"});
}

TEST_CASE("two drivers on one channel are named by their frames, and one can be chosen") {
  std::vector<std::int64_t> utimes;
  const auto PublishTwo = [](Driver& driver, int i) {
    sensor_msgs::LaserScan scan{};
    scan.header.stamp.sec = i + 1;
    scan.header.frame_id = i % 2 == 0 ? "front" : "rear";
    scan.angle_increment = 0.01f;
    scan.range_max = 10.0f;
    scan.ranges.assign(300, 2.0f);
    scan.ranges_length = 300;
    driver.lcm().publish("LASER", &scan);
  };
  const std::string choices = "--laser-frame must name one of front, rear";
  for (const auto& [flags, expected] : std::map<std::vector<std::string>, std::string>{
           {{}, "LASER: the scans are of several lasers: " + choices},
           {{"--laser-frame", "font"}, "LASER: no scan has the frame font: " + choices}}) {
    Driver driver(flags);
    int num_scans = 0;
    CheckLine(driver.AwaitComplaint([&] { PublishTwo(driver, num_scans++); }), expected, {});
  }
  Driver driver({"--laser-frame", "front"});
  TestBus bus(driver.url());
  bus->Subscribe<critical_rays_t>(kCriticalRaysChannel,
                                  [&](const critical_rays_t& rays) { utimes.push_back(rays.utime / 1'000'000); });
  for (int i = 0; i < 4; ++i) PublishTwo(driver, i);
  CHECK(bus.Await([&] { return utimes.size() == 2; }));
  CHECK(utimes == std::vector<std::int64_t>{1, 3});
  CHECK(driver.Complaints().empty());
}

TEST_CASE("a laser whose scans turn against the robot's odometry is said to be mirrored, once") {
  for (const bool mirrored : {false, true}) {
    CAPTURE(mirrored);
    Driver driver;
    int num_scans = 0;
    const auto publish = [&] {  // between a wall that is 1 m away and one that is 2 m away, of a robot that turns left
      const double yaw_rad = WrapAngle(0.15 * num_scans);
      LaserScan scan{1'000'000 + 100'000 * num_scans++, 0.0f, static_cast<float>(2.0 * kPi / 300), {}};
      for (int i = 0; i < 300; ++i) {
        const double y = std::sin(2.0 * kPi * i / 300 + yaw_rad);
        scan.ranges_m.push_back(static_cast<float>(std::min(6.0, (y > 0.0 ? 1.0 : 2.0) / std::abs(y))));
      }
      if (mirrored) scan.angle_step_rad = -scan.angle_step_rad;
      const bot_core::pose_t pose = ToMessage(Odometry{scan.utime, Pose2{0.0, 0.0, yaw_rad}});
      const bot_core::planar_lidar_t message = ToMessage(scan);
      driver.lcm().publish("ODOMETRY", &pose);
      driver.lcm().publish("LASER", &message);
      return num_scans == 60;
    };
    REQUIRE(WaitUntil(publish, std::chrono::milliseconds(20)));
    if (!mirrored) {
      CHECK(driver.Complaints().empty());
    } else {
      CheckLine(driver.AwaitComplaint(),
                "LASER: scans turn in the opposite direction to the poses on ODOMETRY: the map is a mirror image: ",
                {"add --mirrored"});
    }
  }
}

TEST_CASE("a laser that falls silent is missed, and told to be back") {
  Driver driver;
  driver.PublishGood("LASER");
  CheckLine(driver.AwaitComplaint(), "LASER: no scan for 3 s", {"driver"});
  driver.PublishGood("LASER");
  CHECK(WaitUntil([&] { return CountOf("LASER: the laser is back after ", driver.Complaints()) == 1; },
                  std::chrono::milliseconds(50)));
}

TEST_CASE("a driver that begins later on another channel is named, once, while the laser is missed") {
  Driver driver;
  CheckLine(driver.AwaitComplaint(), "LASER: nothing came since the start; no other channel is on this bus", {});
  const std::string named =
      "ray_selector: LASER: there is a laser on LIDAR_FRONT (bot_core.planar_lidar_t): did you mean --laser-channel "
      "\"LIDAR_FRONT\"?\n";
  const auto PublishFor = [&](const std::function<bool()>& done) {
    return WaitUntil(
        [&] {
          driver.PublishGood("LIDAR_FRONT");
          return done();
        },
        std::chrono::milliseconds(50));
  };
  REQUIRE(PublishFor([&] { return driver.Complaints().find(named) != std::string::npos; }));
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(7);  // the bus is heard once more
  REQUIRE(PublishFor([&] { return std::chrono::steady_clock::now() > end; }));
  CHECK(CountOf("\n", driver.Complaints()) == 2);
  driver.PublishGood("LASER");
  CHECK(WaitUntil([&] { return driver.Complaints().find("LASER: the laser is there, ") != std::string::npos; },
                  std::chrono::milliseconds(50)));
}

TEST_CASE("of two drivers on the laser's channel one is used, and both are named by where they send from") {
  Driver driver;
  lcm::LCM other(driver.url());
  const std::vector<LaserScan> scans = TakeScans("sim:rooms", 20);
  std::size_t next = 0;
  const std::string said = driver.AwaitComplaint([&] {
    driver.PublishGood("LASER");
    const bot_core::planar_lidar_t message = ToMessage(scans[next++ % scans.size()]);
    other.publish("LASER", &message);
  });
  CheckLine(
      said, "LASER: scans come from ",
      {":", ", too, and are left out: those of ", " are used: stop one of them, or give it a channel of its own"});
}

TEST_CASE("nothing is said while a publisher waits for a map that does not come, nor after the end of its log") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 20), "run.lcm");
  Driver driver;
  {
    Process waiting("laser_publisher", {log, "--rate", "max", "--lcm-url", driver.url()}, folder / "log");
    REQUIRE(waiting.AwaitReady());
    std::this_thread::sleep_for(std::chrono::seconds(4));
    CHECK(waiting.Interrupt() == 0);
  }
  CHECK(folder.Run("laser_publisher", {log, "--rate", "10", "--lcm-url", driver.url()}).exit_code == 0);
  std::this_thread::sleep_for(std::chrono::seconds(4));
  CHECK(driver.Complaints().empty());
}

TEST_CASE("slam_offline says of a log what is wrong with its laser, and nothing of a good one") {
  const TemporaryFolder folder;
  const auto Said = [&](const std::string& name, const std::function<void(LaserScan&)>& change) {
    std::vector<LaserScan> scans = TakeScans("sim:demo", 40);
    for (LaserScan& scan : scans) change(scan);
    return folder.Run("slam_offline", {folder.Write(scans, name), "--out", folder / "out", "--force"});
  };
  const auto good = Said("good.lcm", [](LaserScan&) {});
  CHECK(good.exit_code == 0);
  CHECK(good.errors.find("good.lcm: 270 beams over 269 degrees, hits to 9.") != std::string::npos);
  CHECK(CountOf("good.lcm", good.errors) == 1);  // and no more
  const auto Expect = [&](const std::function<void(LaserScan&)>& change, const std::string& expected, int exit_code) {
    const auto [code, output, said] = Said("bad.lcm", change);
    CAPTURE(said);
    CHECK(said.find("bad.lcm" + expected) != std::string::npos);
    CHECK(code == exit_code);
  };
  Expect(
      [](LaserScan& scan) {
        for (float& range_m : scan.ranges_m) range_m *= 1000.0f;
      },
      ": ranges look like millimetres", 1);
  Expect([](LaserScan& scan) { scan.utime = 0; },
         ": LASER: 39 of the first 40 scans have the utime of the scan before: the scans are numbered instead", 0);
  Expect([](LaserScan& scan) { scan.angle_min_rad = -90.0f; },
         " has no scans: 40 of 40 scans on LASER are left out: angles look like", 1);
  Expect([](LaserScan& scan) { scan.ranges_m.resize(1); },
         " has no scans: 40 of 40 scans on LASER are left out: scans have 1 rays", 1);
}

TEST_CASE("run_stack says of a live laser whose clock went back that scans are left out") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Process stack = folder.StartStack("live", "out", url);
  REQUIRE(stack.AwaitSaid("listening"));
  lcm::LCM lcm(url);
  const std::vector<LaserScan> scans = TakeScans("sim:demo", 40);
  TestBus bus(url);
  std::int64_t last = 0;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t& match) { last = match.utime; });
  for (std::size_t i = 0; i < 46; ++i) {
    const bot_core::planar_lidar_t message = ToMessage(scans[i % scans.size()]);
    lcm.publish("LASER", &message);
    REQUIRE(bus.Await([&] { return last == message.utime; }));
  }
  CHECK(stack.AwaitSaid("rrhc_matcher: 3 of the last 43 scans repeat the utime of an earlier scan and are left out"));
  stack.Interrupt();
}
