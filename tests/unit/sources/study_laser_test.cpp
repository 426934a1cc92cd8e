#include "services/sources/study_laser.hpp"

#include "bags/bag_bytes.hpp"
#include "bags/transform_bytes.hpp"
#include "catch.hpp"
#include "common/worlds/simulator.hpp"
#include "lcm_events.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"
#include "source_helpers.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// What a robot does that stands for some scans and then turns, and what its log has of that.
struct Drive {
  bool is_mirrored = false;
  bool has_odometry = true;
  int stands_for = 0;  ///< scans
};

/// Scans of a drive in a room with a box in it, of which no two sides are alike, and where they were taken.
std::vector<std::pair<LaserScan, Pose2>> ScansOf(const Drive& drive) {
  const std::vector<Wall> walls = ParseWorld(
                                      "box -3 -2 7 4.5\nbox 1 0.5 1.5 0.8\nwall -3 0 -1.5 0\n"
                                      "waypoint 0 -1\nwaypoint 0.5 -1\nspeed 1 1\nlaser 360 360 10 10 0\n",
                                      "room")
                                      .walls;
  std::vector<std::pair<LaserScan, Pose2>> scans;
  for (int k = 0; k < drive.stands_for + 30; ++k) {
    const Pose2 pose{0.0, -1.0, WrapAngle(0.15 * std::max(0, k - drive.stands_for))};
    const LaserScan scan = ScanWalls(walls, pose, 1'000'000 + 100'000 * k);
    scans.emplace_back(drive.is_mirrored ? Mirror(scan) : scan, pose);
  }
  return scans;
}

std::string LogOf(const Drive& drive) {
  std::string log;
  for (const auto& [scan, pose] : ScansOf(drive)) {
    if (drive.has_odometry) log += Event("ODOMETRY", DataOf(ToMessage(Odometry{scan.utime, pose})));
    log += Event("LASER", DataOf(ToMessage(scan)));
  }
  return log;
}

/// The same with odometry, as a bag by whose TF the laser hangs upside down.
std::string UpsideDownBagOf(const Drive& drive) {
  std::string records = Ros1Connection(1, "/scan") + Ros1Connection(2, "/odom", "nav_msgs/Odometry") +
                        Ros1Connection(3, "/tf_static", "tf2_msgs/TFMessage");
  records += Ros1Message(3, Ros1Transforms({{.parent = "base_link", .child = "las", .rotation = {1, 0, 0, 0}}}));
  for (const auto& [scan, pose] : ScansOf(drive)) {
    const auto sec = static_cast<std::uint32_t>(scan.utime / 1'000'000);
    const auto nanosec = static_cast<std::uint32_t>(scan.utime % 1'000'000 * 1000);
    const double half_rad = 0.5 * pose.yaw_rad;
    records += Ros1Message(
        2, Ros1Odometry({.rotation = {0, 0, std::sin(half_rad), std::cos(half_rad)}, .sec = sec, .nanosec = nanosec}));
    records += Ros1Message(1, LaserMessage{.sec = sec,
                                           .nanosec = nanosec,
                                           .angle_min = scan.angle_min_rad,
                                           .angle_increment = scan.angle_step_rad,
                                           .ranges = scan.ranges_m}
                                  .Ros1());
  }
  return Ros1Bytes(records);
}

/// The command line of a program that reads logs.
struct Program : CommandLine {
  explicit Program(const std::vector<std::string>& words = {})
      : CommandLine("program", "", {ParameterGroup::kSeed, ParameterGroup::kLaser, ParameterGroup::kScan},
                    {"laser_channel", "laser_frame", "odometry", "odometry_topic", "botlab_clockwise", "mirrored"}) {
    std::vector<const char*> arguments{"program"};
    for (const std::string& word : words) arguments.push_back(word.c_str());
    REQUIRE_FALSE(Parse(static_cast<int>(arguments.size()), arguments.data()));
  }
};

LaserScan FirstScan(const std::string& log, const CommandLine& line) {
  return *OpenLaserSource(log, SourceOptionsOf(line))->Next();
}

}  // namespace

TEST_CASE(
    "scans that turn against the odometry of their log are turned round, used or not, and however late they turn") {
  for (const int stands_for : {0, 500}) {
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{}, {"--no-odometry"}}) {
      const ScratchFile right(LogOf({.stands_for = stands_for}));
      const ScratchFile mirrored(LogOf({.is_mirrored = true, .stands_for = stands_for}));
      Program line(words);
      StudyLaser(right.path(), line);
      CHECK_FALSE(line.settings().mirrored);
      const LaserScan expected = FirstScan(right.path(), line);
      StudyLaser(mirrored.path(), line);
      CHECK(line.settings().mirrored);
      CHECK(FirstScan(mirrored.path(), line) == expected);
    }
  }
}

TEST_CASE("the sweep of a laser whose messages tell none is corrected, unless a flag says another one, or none") {
  Simulator simulator(LoadWorld("arena"), 1);
  std::string log;
  while (const auto scan = simulator.Next()) log += Event("LASER", DataOf(ToMessage(*scan)));
  const ScratchFile arena(log);
  const auto SweepOf = [&](const std::vector<std::string>& words) {
    Program line(words);
    StudyLaser(arena.path(), line);
    return line.parameters().scan.sweep_s;
  };
  CHECK(SweepOf({}) == Approx(0.15).margin(0.002));
  CHECK(SweepOf({"--sweep-s", "-0.1"}) == -0.1);
  CHECK(SweepOf({"--sweep-s", "0"}) == 0.0);
  CHECK(SweepOf({"--no-beam-times"}) == 0.0);
}

TEST_CASE("without odometry, or with a flag that says it, no scans are turned round by themselves") {
  const ScratchFile silent(LogOf({.is_mirrored = true, .has_odometry = false}));
  Program line;
  StudyLaser(silent.path(), line);
  CHECK_FALSE(line.settings().mirrored);
  const ScratchFile mirrored(LogOf({.is_mirrored = true}));
  for (const bool flag : {true, false}) {
    Program typed({flag ? "--mirrored" : "--no-mirrored"});
    StudyLaser(mirrored.path(), typed);
    CHECK(typed.settings().mirrored == flag);
  }
}

TEST_CASE(
    "the scans of a laser that hangs upside down by TF are turned round, also in parts of a bag that have no TF") {
  const auto BagOf = [](bool has_tf, std::uint32_t sec) {
    const TransformFields mounting{.parent = "base_link", .child = "las", .rotation = {1, 0, 0, 0}};
    std::string records = Ros1Connection(1, "/scan") + Ros1Connection(2, "/tf_static", "tf2_msgs/TFMessage");
    if (has_tf) records += Ros1Message(2, Ros1Transforms({mounting}));
    return Ros1Bytes(records + Ros1Message(1, LaserMessage{.sec = sec}.Ros1()));
  };
  const ScratchFolder folder;
  folder.Write("run_0.bag", BagOf(true, 1));
  folder.Write("run_1.bag", BagOf(false, 2));
  const ScratchFile first(BagOf(true, 1));
  const ScratchFile further(BagOf(false, 2));
  const LaserScan as_sent = *OpenLaserSource(first.path(), {})->Next();
  for (const std::string& name : {(folder / "run_*.bag").string(), first.path()}) {
    Program line;
    StudyLaser(name, line);
    CHECK(line.settings().mirrored);
    for (const LaserScan& scan : ReadAll(*OpenLaserSource(name, SourceOptionsOf(line)))) {
      CHECK(scan.angle_step_rad == -as_sent.angle_step_rad);
    }
    CHECK_FALSE(StudyFurtherLog(further.path(), line).is_mirrored);  // it is turned round as the first one is
    Program insists({"--no-mirrored"});
    StudyLaser(name, insists);
    CHECK_FALSE(insists.settings().mirrored);
  }
  Program upright;
  StudyLaser(further.path(), upright);
  CHECK_FALSE(upright.settings().mirrored);
  CHECK(StudyFurtherLog(first.path(), upright).is_mirrored);
}

TEST_CASE("where odometry and TF tell opposite things of the scans, odometry is right, and a flag says so to all") {
  const ScratchFile mirrored(UpsideDownBagOf({.is_mirrored = true}));
  Program agreed;
  StudyLaser(mirrored.path(), agreed);
  CHECK(agreed.settings().mirrored);
  const ScratchFile right(UpsideDownBagOf({}));
  Program against_tf;
  StudyLaser(right.path(), against_tf);
  CHECK_FALSE(against_tf.settings().mirrored);
  CHECK(against_tf.WordsFor(FlagsOfPublisher()) == std::vector<std::string>{"--no-mirrored"});
}

TEST_CASE("each log of a map is turned round or not by its own odometry") {
  const ScratchFile right(LogOf({}));
  const ScratchFile mirrored(LogOf({.is_mirrored = true}));
  for (const ScratchFile* first : {&right, &mirrored}) {
    for (const ScratchFile* further : {&right, &mirrored}) {
      Program line;
      StudyLaser(first->path(), line);
      const ScanCorrection correction = StudyFurtherLog(further->path(), line);
      CHECK(correction.is_mirrored == (first != further));
      CHECK(correction.Apply(FirstScan(further->path(), line)) == FirstScan(first->path(), line));
    }
  }
}

TEST_CASE("a source that is said to be mirrored gives its scans turned round, and nothing else differs") {
  const ScratchFile lcm(LogOf({}));
  const std::string data = CRSM_SOURCE_DIR "/tests/bags/data/";
  const ScratchFile carmen("FLASER 4 1 2 3 4 0 0 0 1.5 2.5 0.5 17.5 host 0.1\n");
  for (const std::string& name :
       {lcm.path(), carmen.path(), data + "run.db3", data + "lz4.bag", std::string("sim:demo")}) {
    CAPTURE(name);
    const auto as_it_is = OpenLaserSource(name, {});
    const auto turned = OpenLaserSource(name, {.messages = {.mirrored = true}});
    const LaserScan scan = *as_it_is->Next();
    CHECK(turned->Next() == Mirror(scan));
    CHECK(turned->Odometry() == as_it_is->Odometry());
    CHECK(turned->TruePose() == as_it_is->TruePose());
    CHECK(turned->Channel() == as_it_is->Channel());
    CHECK(turned->Progress() == as_it_is->Progress());
    CHECK(turned->Counts() == as_it_is->Counts());
    CHECK(turned->Complaints() == as_it_is->Complaints());
    CHECK(turned->OdometryNotes() == as_it_is->OdometryNotes());
  }
}

}  // namespace crsm
