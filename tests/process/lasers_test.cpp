// Lasers of other people's types: from logs and live, on channels of their own.

#include <botlab/lidar_t.hpp>
#include <fstream>
#include <sensor_msgs/LaserScan.hpp>
#include <thread>

#include "catch.hpp"
#include "common/metrics/trajectory.hpp"
#include "common/worlds/simulator.hpp"
#include "processes.hpp"
#include "services/wire/event_log_writer.hpp"

using namespace crsm;

namespace {

/// A student's robot in its arena, as botlab says it: clockwise, in the order in which the laser turns, with times.
std::vector<botlab::lidar_t> BotlabScans(std::size_t count) {
  constexpr std::int64_t kSweep_us = 150'000;
  Simulator simulator(LoadWorld("arena"), 1);
  std::vector<botlab::lidar_t> messages;
  while (const auto scan = simulator.Next()) {
    if (messages.size() == count) break;
    botlab::lidar_t message{};
    const auto last = static_cast<std::int64_t>(scan->ranges_m.size()) - 1;
    message.utime = scan->utime;
    for (std::int64_t i = 0; i <= last; ++i) {
      const double angle_rad = scan->angle_min_rad + static_cast<double>(i) * scan->angle_step_rad;
      message.thetas.push_back(static_cast<float>(-angle_rad));
      message.ranges.push_back(scan->ranges_m[static_cast<std::size_t>(i)]);
      message.times.push_back(scan->utime - kSweep_us + kSweep_us * i / last + i % 2);  // not quite even
      message.intensities.push_back(1.0f);
    }
    message.times.back() = scan->utime;
    message.num_ranges = static_cast<std::int32_t>(message.ranges.size());
    messages.push_back(std::move(message));
  }
  return messages;
}

void WriteBotlabLog(const std::filesystem::path& path, std::size_t count) {
  EventLogWriter log(path.string());
  for (const botlab::lidar_t& message : BotlabScans(count)) log.Write("LIDAR", message);
  log.Flush();
}

}  // namespace

TEST_CASE("a log of botlab's with times is mapped alike by one process and by all, and deskewed without a flag") {
  const TemporaryFolder folder;
  WriteBotlabLog(folder / "run.lcm", 150);
  const std::string log = folder / "run.lcm";
  const std::vector<std::string> cell{"--cell-size-m", "0.03"};
  std::vector<std::string> flags = cell;
  flags.insert(flags.end(), {"--laser-channel", "LIDAR"});
  folder.Map(log, "offline", flags);
  folder.MapWithStack(log, "out", flags);
  folder.CheckSame("out", "offline");
  // Converted to a log of ours it keeps the times.
  const std::string ours = folder / "ours.lcm";
  REQUIRE(folder.Run("laser_publisher", {log, "--lcm-url", "file://" + ours + "?mode=w"}).exit_code == 0);
  folder.Map(ours, "ours", cell);
  folder.CheckSame("ours", "offline");
}

TEST_CASE("both handednesses of one log give maps that are mirror images, and a map goes on with its own") {
  const TemporaryFolder folder;
  WriteBotlabLog(folder / "run.lcm", 150);
  const std::vector<std::string> cell{"--cell-size-m", "0.03"};
  folder.Map(folder / "run.lcm", "right", cell);
  folder.Map(folder / "run.lcm", "mirrored", {"--no-botlab-clockwise", "--cell-size-m", "0.03"});
  const auto right = ReadTrajectory(folder / "right/trajectory.tum");
  const auto mirrored = ReadTrajectory(folder / "mirrored/trajectory.tum");
  REQUIRE(right.size() == 150);
  REQUIRE(mirrored.size() == 150);
  double turned_rad = 0.0;
  // To two cells, and 0.1 rad, which it turns in a third of a sweep: random numbers differ.
  for (std::size_t i = 0; i < right.size(); ++i) {
    const auto& [x_m, y_m, yaw_rad] = right[i].T_map_laser;
    const auto& [mirrored_x_m, mirrored_y_m, mirrored_yaw_rad] = mirrored[i].T_map_laser;
    CHECK(std::abs(mirrored_x_m - x_m) < 0.06);
    CHECK(std::abs(mirrored_y_m + y_m) < 0.06);
    CHECK(std::abs(WrapAngle(mirrored_yaw_rad + yaw_rad)) < 0.1);
    turned_rad = std::max(turned_rad, std::abs(yaw_rad));
  }
  CHECK(turned_rad > 1.5);  // the robot has turned round: a mirror image differs
  const std::string map = ReadFile(folder / "mirrored/map.png");
  folder.Map(folder / "run.lcm", "mirrored", {"--resume", folder / "mirrored"});  // without the flag: the journal knows
  CHECK((ReadFile(folder / "mirrored/map.png") == map));
}

TEST_CASE("run_stack maps a live laser of botlab's or ROS's on the channel that it is told, and says where one is") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  const std::string channel = "/scan#sensor_msgs.LaserScan";
  lcm::LCM lcm(url);
  Process stack = folder.StartStack("live", "out", url, {"--laser-channel", channel});
  REQUIRE(stack.AwaitSaid("listening"));
  const std::vector<botlab::lidar_t> scans = BotlabScans(1);
  std::int64_t utime = 1'000'000;
  REQUIRE(WaitUntil(
      [&] {
        botlab::lidar_t elsewhere = scans[0];
        lcm.publish("LIDAR", &elsewhere);
        return stack.errors().find("ray_selector: " + channel +
                                   ": nothing came since the start; this bus has LIDAR "
                                   "(botlab.lidar_t): did you mean --laser-channel \"LIDAR\"?") != std::string::npos;
      },
      std::chrono::milliseconds(50)));
  std::int64_t last = 0;
  TestBus bus(url);
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t& match) { last = match.utime; });
  // Both types on one channel: each message says what it is.
  for (int k = 0; k < 20; ++k, utime += 1'000'000) {
    if (k % 2 == 0) {
      botlab::lidar_t message = scans[0];
      message.times.assign(message.times.size(), 0);
      message.utime = utime;
      lcm.publish(channel, &message);
    } else {
      sensor_msgs::LaserScan message{};
      message.header.stamp.sec = static_cast<std::int32_t>(utime / 1'000'000);
      message.angle_min = scans[0].thetas[0] * -1.0f;
      message.angle_increment = scans[0].thetas[0] - scans[0].thetas[1];
      message.ranges = scans[0].ranges;
      message.ranges_length = scans[0].num_ranges;
      lcm.publish(channel, &message);
    }
    REQUIRE(bus.Await([&] { return last == utime; }));
  }
  CHECK(stack.Interrupt() == 0);
  const auto path = ReadTrajectory(folder / "out/trajectory.tum");
  REQUIRE(path.size() == 20);
  for (const StampedPose& pose : path) CHECK(Length(pose.T_map_laser) < 0.05);  // it stands: a cell
}
