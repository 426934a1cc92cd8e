// Several robots on one common map: run_stack --robots, the fleet mapper killed on the way, and wrong calls.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <sstream>

#include "catch.hpp"
#include "common/results/mark_files.hpp"
#include "processes.hpp"
#include "services/journal/journal.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

/// sim:demo, driven from another corner on and the other way round, in two files.
class TwoDrives : public TemporaryFolder {
 public:
  TwoDrives() {
    std::istringstream world(ReadFile(fs::path(CRSM_SOURCE_DIR) / "common/worlds/demo.world"));
    std::string head;
    std::vector<std::string> waypoints;
    for (std::string line; std::getline(world, line);) {
      if (line.starts_with("waypoint")) {
        waypoints.push_back(line);
      } else {
        head += line + '\n';
      }
    }
    starts_[0] = Write(head, waypoints, first());
    std::reverse(waypoints.begin(), waypoints.end());
    waypoints.erase(waypoints.begin());  // the last one is the first
    std::rotate(waypoints.begin(), waypoints.begin() + 12, waypoints.end());
    starts_[1] = Write(head, waypoints, second());
  }

  fs::path first() const { return *this / "first.world"; }
  fs::path second() const { return *this / "second.world"; }

  /// The frame of the second robot as seen from that of the first: where they truly started.
  Pose2 T_first_second() const { return Inverse(starts_[0]) * starts_[1]; }

  Process Start(const std::string& url, const std::vector<std::string>& flags) const {
    std::vector<std::string> all{"--robots", "2", "sim:" + second().string()};
    all.insert(all.end(), flags.begin(), flags.end());
    return StartStack("sim:" + first().string(), "fleet", url, all);
  }

  std::int64_t CountKeyframes(const std::string& out) const {
    std::int64_t num = 0;
    const auto summary = Summary(out);
    for (const auto& piece : summary["pieces"]["largest_first"]) num += piece["keyframes"].get<std::int64_t>();
    return num;
  }

 private:
  static Pose2 Write(const std::string& head, const std::vector<std::string>& waypoints, const fs::path& file) {
    std::ofstream out(file);
    out << head;
    for (const std::string& line : waypoints) out << line << '\n';
    const auto PointOf = [](const std::string& line) {
      std::istringstream words(line);
      std::string word;
      Pose2 point;
      words >> word >> point.x_m >> point.y_m;
      return point;
    };
    Pose2 start = PointOf(waypoints[0]);
    const Pose2 next = PointOf(waypoints[1]);
    start.yaw_rad = std::atan2(next.y_m - start.y_m, next.x_m - start.x_m);
    return start;
  }

  Pose2 starts_[2];
};

/// What the fleet mapper says of the robots, the last of each.
struct FleetPoses {
  explicit FleetPoses(const std::string& url) : bus(url, "fleet/") {
    bus->Subscribe<fleet_pose_t>(kFleetPoseChannel, [this](const fleet_pose_t& pose) { last[pose.robot] = pose; });
  }
  bool AwaitJoined() {
    return bus.Await([this] {
      return last.size() == 2 && std::ranges::all_of(last, [](const auto& one) { return one.second.floating == 0; });
    });
  }

  /// The frame of the second robot as seen from that of the first.
  Pose2 T_first_second() const {
    const auto FrameOf = [&](const char* robot) { return FromMessage(last.at(robot).T_common_map); };
    return Inverse(FrameOf("robot1/")) * FrameOf("robot2/");
  }

  TestBus bus;
  std::map<std::string, fleet_pose_t> last;
};

}  // namespace

TEST_CASE("two robots that start elsewhere in a flat end on one common map, and are where they truly are") {
  const TwoDrives drives;
  const std::string url = MakeBusUrl();
  FleetPoses poses(url);
  Process stack = drives.Start(url, {"--rate", "30"});
  CHECK(poses.AwaitJoined());
  while (stack.IsRunning()) poses.bus->Wait(20);
  INFO(stack.errors());
  REQUIRE(stack.AwaitExit() == 0);
  const Pose2 error = Inverse(drives.T_first_second()) * poses.T_first_second();
  CHECK(Length(error) < 0.05);  // a cell: each robot is within a centimetre of the truth there
  CHECK(std::abs(error.yaw_rad) < 0.01);
  // One of them has the frame of all, and the other one is known to be somewhere.
  CHECK((poses.last.at("robot1/").trajectories == std::vector{0} ||
         poses.last.at("robot2/").trajectories == std::vector{0}));
  // 360 motions that are good to 0.011 m each, and loops with the other robot that are good to 0.1 m.
  for (const auto& [robot, pose] : poses.last) CHECK(pose.covariance[0] < 0.055);

  const auto summary = drives.Summary("fleet");
  CHECK(summary["pieces"]["count"] == 1);
  CHECK(summary["verdict"]["trust"] == "good");
  CHECK(summary["scans"] == drives.CountKeyframes("fleet/robot1") + drives.CountKeyframes("fleet/robot2"));
  CHECK(summary["counts"]["fleet_mapper.loops_between_robots"] >= 2);
  // What one robot makes of the flat alone.
  const auto alone = drives.Summary("fleet/robot1");
  CHECK(summary["explored_area_m2"].get<double>() > 0.97 * alone["explored_area_m2"].get<double>());
  CHECK(summary["explored_area_m2"].get<double>() < 1.05 * alone["explored_area_m2"].get<double>());
}

TEST_CASE("a fleet mapper that is killed goes on where it was, and the common map has all keyframes of all robots") {
  const TwoDrives drives;
  const std::string url = MakeBusUrl();
  FleetPoses poses(url);
  Process stack = drives.Start(url, {"--rate", "20"});
  for (int i = 0; i < 2; ++i) {
    const std::int64_t before = poses.bus.Count("fleet_mapper.keyframes");
    REQUIRE(poses.bus.Await([&] { return poses.bus.Count("fleet_mapper.keyframes") > before + 40; }));
    kill(FindChild(stack.pid(), "fleet_mapper"), SIGKILL);
  }
  REQUIRE(stack.AwaitExit() == 0);
  CHECK(CountOf("fleet_mapper ended with signal 9, and is started again", stack.errors()) == 2);
  CHECK(CountOf("continues after", ReadFile(drives / "fleet/log/fleet_mapper.log")) == 2);
  const auto summary = drives.Summary("fleet");
  CHECK(summary["pieces"]["count"] == 1);
  CHECK(summary["scans"] == drives.CountKeyframes("fleet/robot1") + drives.CountKeyframes("fleet/robot2"));
}

TEST_CASE("the marks of two robots end on the common map, each once, though the fleet mapper is killed") {
  const TwoDrives drives;
  const std::string url = MakeBusUrl();
  FleetPoses poses(url);
  Process stack = drives.Start(url, {"--rate", "20"});
  for (const char* robot : {"robot1/", "robot2/"}) {
    TestBus bus(url, robot);
    std::int64_t utime = -1;
    bool is_kept = false;
    bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t& match) { utime = match.utime; });
    bus->Subscribe<mark_t>(kMarkAnswerChannel, [&](const mark_t&) { is_kept = true; });
    REQUIRE(bus.Await([&] { return utime >= 0; }));
    // Both where the first robot started, as each of them has it.
    const Pose2 at = robot == std::string("robot1/") ? Pose2{} : Inverse(drives.T_first_second());
    const Mark mark{utime, "v", "victim", "in the hall", MarkAction::kSeen, true, 0.3, {{at.x_m, at.y_m}}};
    REQUIRE(bus.Await([&] {
      if (!is_kept) bus->Publish(kMarkChannel, ToMessage(mark));
      return is_kept;
    }));
  }
  REQUIRE(poses.bus.Await([&] { return poses.bus.Count("fleet_mapper.marks") == 2; }));
  kill(FindChild(stack.pid(), "fleet_mapper"), SIGKILL);
  REQUIRE(stack.AwaitExit() == 0);
  const auto marks = ReadMarks(drives / "fleet");
  REQUIRE(marks.size() == 2);
  CHECK(marks[0].id == "robot1/v");
  CHECK(marks[0].name == "robot1: in the hall");
  CHECK(marks[1].id == "robot2/v");
  for (const PlacedMark& mark : marks) {
    CHECK_FALSE(mark.floating);
    CHECK(mark.num_sightings == 1);
  }
  // They lie at one place: the robots are joined to within a cell, and the far one is 0.01 rad off at 10 m.
  CHECK(Distance(Pose2{marks[0].points[0].x_m, marks[0].points[0].y_m, 0.0},
                 Pose2{marks[1].points[0].x_m, marks[1].points[0].y_m, 0.0}) < 0.15);
  CHECK(ReadFile(drives / "fleet/marks.geojson").find("robot2/v") != std::string::npos);
  // A fleet mapper that goes on has them without the robots.
  const std::string later = MakeBusUrl();
  TestBus bus(later, "fleet/");
  const Process again("fleet_mapper",
                      {"--lcm-url", later, "--channel-prefix", "fleet/", "--robots", "robot1/", "--resume", "--journal",
                       JournalFolder(drives / "fleet").string()},
                      drives / "again");
  CHECK(bus.Await([&] { return bus.Count("fleet_mapper.marks") == 2; }));
}

TEST_CASE("fleets that there cannot be are refused in one line") {
  const TwoDrives drives;
  const std::string source = "sim:" + drives.first().string();
  drives.CheckRefused("run_stack", {source, "--robots", "1", "--out", (drives / "a").string()}, "must be 2 to 64");
  drives.CheckRefused("run_stack", {source, "--robots", "x", "--out", (drives / "a").string()}, "must be 2 to 64");
  drives.CheckRefused("run_stack", {source, source, "--robots", "3", "--out", (drives / "a").string()}, "one for each");
  drives.CheckRefused("run_stack", {source, source, "--out", (drives / "a").string()}, "add --robots");
  drives.CheckRefused("run_stack", {source, "--robots", "2", "--no-loops", "--out", (drives / "a").string()},
                      "remove --no-loops");
  const std::string url = MakeBusUrl();
  drives.CheckRefused("fleet_mapper", {"--lcm-url", url}, "--robots: is missing");
  drives.CheckRefused("fleet_mapper", {"--lcm-url", url, "--robots", "fleet/"}, "is the prefix of the fleet itself");
  drives.CheckRefused("fleet_mapper", {"--lcm-url", url, "--robots", "robot1/", "--resume"},
                      "--resume needs --journal");
}

TEST_CASE("the journal of one robot makes no fleet, and that of a fleet no robot") {
  const TwoDrives drives;
  drives.Map("sim:" + drives.first().string(), "alone");
  const std::string url = MakeBusUrl();
  drives.CheckRefused(
      "fleet_mapper",
      {"--lcm-url", url, "--robots", "robot1/", "--resume", "--journal", (drives / "alone/journal").string()},
      "is the journal of one robot", 1);
}
