#include "services/sources/lcm_log_source.hpp"

#include <sys/stat.h>

#include <bot_core/planar_lidar_t.hpp>
#include <botlab/lidar_t.hpp>
#include <cmath>
#include <limits>
#include <mbot_lcm_msgs/pose2D_t.hpp>
#include <sensor_msgs/LaserScan.hpp>

#include "catch.hpp"
#include "common/math/trigonometry.hpp"
#include "lcm_events.hpp"
#include "real_logs.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

using Utimes = std::vector<std::int64_t>;
using Lines = std::vector<std::string>;
using Odometries = std::vector<std::optional<double>>;

bot_core::planar_lidar_t PlanarLidar(std::int64_t utime) {
  bot_core::planar_lidar_t lidar;
  lidar.utime = utime;
  lidar.ranges = {1.0f, 2.5f, 0.0f, std::numeric_limits<float>::infinity()};
  lidar.nranges = 4;
  lidar.intensities = {7.0f, 8.0f, 9.0f, 10.0f};
  lidar.nintensities = 4;
  lidar.rad0 = -1.5f;
  lidar.radstep = 0.25f;
  return lidar;
}

std::string PlanarEvent(std::int64_t utime, const std::string& channel = "LASER") {
  return Event(channel, DataOf(PlanarLidar(utime)));
}

std::string OdometryEvent(std::int64_t utime, std::optional<double> x_m, const std::string& channel = "ODOMETRY") {
  const auto pose = x_m ? std::optional(Pose2{*x_m, 2.0, -3.0}) : std::nullopt;
  return Event(channel, DataOf(ToMessage(Odometry{utime, pose})));
}

/// All that a log gives.
struct Result {
  std::vector<LaserScan> scans;
  Odometries odometry_x_m;  ///< of each scan
  std::map<std::string, std::int64_t> counts;
  Lines notes;  ///< on the odometry
  Lines complaints;

  Utimes utimes() const { return UtimesOf(scans); }
};

Result Read(const std::string& log, const LaserChoice& laser = {}, const LaserMessageOptions& messages = {},
            const std::string& odometry = "") {
  const ScratchFile file(log);
  LcmLogSource source(file.path(), laser, messages, odometry);
  Result result;
  while (auto scan = source.Next()) {
    result.scans.push_back(*scan);
    const auto T_odom_robot = source.Odometry();
    result.odometry_x_m.push_back(T_odom_robot ? std::optional(T_odom_robot->x_m) : std::nullopt);
    if (T_odom_robot) CHECK(*T_odom_robot == Pose2{T_odom_robot->x_m, 2.0, -3.0});
  }
  result.counts = source.Counts();
  result.notes = source.OdometryNotes();
  result.complaints = source.Complaints();
  return result;
}

/// What is wrong with a file, without its path.
std::string ErrorOfLog(const std::string& log, const LaserChoice& laser = {}, const std::string& odometry = "") {
  const ScratchFile file(log);
  const std::string error = ErrorOf([&] { LcmLogSource(file.path(), laser, {}, odometry); });
  CHECK(error.starts_with(file.path()));
  return error.substr(file.path().size());
}

}  // namespace

TEST_CASE("a planar lidar message is read as it was sent, plain and compressed") {
  const LaserScan expected{11, -1.5f, 0.25f, {1.0f, 2.5f, 0.0f, std::numeric_limits<float>::infinity()}};
  const std::string log = Event("ODOMETRY", "something else") + PlanarEvent(11);
  CHECK(Read(log).scans == std::vector<LaserScan>{expected});
  CHECK(Read(Compress(log)).scans == std::vector<LaserScan>{expected});
  CHECK(Read(log).counts == std::map<std::string, std::int64_t>{{"bad_event", 0}, {"truncated", 0}});
}

TEST_CASE("a scan has the odometry of its own utime, or what lies between the two messages around it") {
  const std::string log = OdometryEvent(1'000'000, 1.0) + PlanarEvent(1'000'000) + PlanarEvent(1'010'000) +
                          PlanarEvent(1'030'000) + OdometryEvent(1'040'000, 5.0) + OdometryEvent(1'060'000, 9.0) +
                          PlanarEvent(1'050'000);
  CHECK(Read(log).odometry_x_m == Odometries{1.0, 2.0, 4.0, 7.0});
}

TEST_CASE("odometry of an mbot is odometry, rounded as all is") {
  const auto MbotEvent = [](std::int64_t utime, float x_m, float theta_rad = -3.0f) {
    return Event("ODOMETRY", DataOf(mbot_lcm_msgs::pose2D_t{utime, x_m, 2.0f, theta_rad}));
  };
  CHECK(Read(MbotEvent(1'000'000, 1.0f) + PlanarEvent(1'000'000) + PlanarEvent(1'010'000) + MbotEvent(1'020'000, 2.0f))
            .odometry_x_m == Odometries{1.0, 1.5});
  CHECK(Read(MbotEvent(1, std::nanf("")) + PlanarEvent(1)).counts.at("bad_odometry") == 1);
  const ScratchFile file(MbotEvent(1, 0.1f, 7.0f) + PlanarEvent(1));
  LcmLogSource source(file.path(), {});
  source.Next();
  CHECK(source.Odometry() == RoundOdometry({0.1f, 2.0, WrapAngle(7.0)}));
}

TEST_CASE("a scan has no odometry where there is none around it, none that can be read, or only another robot's") {
  const std::string before_the_first = PlanarEvent(1'000'000) + OdometryEvent(1'000'001, 1.0);
  const std::string after_the_last = OdometryEvent(1'000'000, 1.0) + PlanarEvent(1'000'001);
  const std::string gap = OdometryEvent(1'000'000, 1.0) + PlanarEvent(1'050'000) + OdometryEvent(1'150'001, 1.0);
  const std::string said_so = OdometryEvent(1, 1.0) + OdometryEvent(2, std::nullopt) + PlanarEvent(2);
  const std::string bad = OdometryEvent(1, std::nan("")) + PlanarEvent(1);
  for (const std::string& log : {before_the_first, after_the_last, gap, said_so, bad}) {
    CHECK(Read(log).odometry_x_m == Odometries{std::nullopt});
  }
  CHECK(Read(bad).counts.at("bad_odometry") == 1);
  const std::string of_another = OdometryEvent(1, 1.0, "robot2/ODOMETRY") + OdometryEvent(2, 2.0, "robot1/ODOMETRY") +
                                 PlanarEvent(1, "robot1/LASER") + PlanarEvent(2, "robot1/LASER");
  CHECK(Read(of_another).odometry_x_m == Odometries{std::nullopt, 2.0});
}

TEST_CASE("odometry of any channel with poses is used if it is named, and its absence lists what there is") {
  const std::string log = OdometryEvent(1, 1.0) + OdometryEvent(1, 2.0, "VICON") + PlanarEvent(1);
  CHECK(Read(log, {}, {}, "VICON").odometry_x_m == Odometries{2.0});
  CHECK(ErrorOfLog(log, {}, "LASER") ==
        " has no pose messages (bot_core.pose_t, mbot_lcm_msgs.pose2D_t) on channel LASER; its channels: "
        "LASER (1), ODOMETRY (1, pose), VICON (1, pose)");
}

TEST_CASE("what is told of the odometry: that it is used, or why not") {
  const std::string good = OdometryEvent(1, 1.0) + PlanarEvent(1) + PlanarEvent(300'000);
  CHECK(Read(good).notes == Lines{"gives odometry to 1 of 2 scans (ODOMETRY)"});
  CHECK(Read(PlanarEvent(1)).notes.empty());
  CHECK(Read(PlanarEvent(1) + OdometryEvent(1, 1.0, "TRUE_POSE")).notes.empty());
  CHECK(Read(PlanarEvent(1) + OdometryEvent(1, 1.0, "VICON")).notes.at(0).ends_with("channel with poses: VICON"));
  const std::string far = OdometryEvent(5'000'000, 1.0) + PlanarEvent(1);
  CHECK(Read(far).notes.at(0).starts_with("has odometry (ODOMETRY), but gives it to no scan: "));
}

TEST_CASE("odometry that is late is waited for, until eight more scans have come, or one that is a second later") {
  const auto log = [](int num_later_scans, std::int64_t step_us) {
    std::string events = OdometryEvent(999'999, 1.0) + PlanarEvent(1'000'000);
    for (int i = 1; i <= num_later_scans; ++i) events += PlanarEvent(1'000'000 + i * step_us);
    return events + OdometryEvent(1'000'001, 3.0);
  };
  CHECK(Read(log(7, 1'000)).odometry_x_m.at(0) == 2.0);
  CHECK(Read(log(8, 1'000)).odometry_x_m.at(0) == std::nullopt);
  CHECK(Read(log(1, 1'000'000)).odometry_x_m.at(0) == 2.0);
  CHECK(Read(log(1, 1'000'001)).odometry_x_m.at(0) == std::nullopt);
  CHECK(Read(log(8, 1'000)).scans.size() == 9);
}

TEST_CASE("of several lasers the first one's scans are taken, or those of the channel asked for") {
  const std::string log = PlanarEvent(1, "FRONT") + PlanarEvent(2, "REAR") + PlanarEvent(3, "FRONT");
  CHECK(Read(log).utimes() == Utimes{1, 3});
  CHECK(Read(log).counts.at("other_channel") == 1);
  CHECK(Read(log, {"REAR"}).utimes() == Utimes{2});
  CHECK(Read(log, {"REAR"}).counts.at("other_channel") == 2);
}

TEST_CASE("all other lasers of a log are named") {
  const auto Said = [](const std::string& log) {
    const Lines complaints = Read(log).complaints;
    REQUIRE(complaints.size() == 1);
    return complaints[0];
  };
  const std::string three = PlanarEvent(1, "FRONT") + PlanarEvent(1, "REAR") + PlanarEvent(1, "LEFT");
  CHECK(Said(PlanarEvent(1, "FRONT") + PlanarEvent(2, "REAR")) ==
        "the scans are those on FRONT; there is a laser on REAR, too: --laser-channel takes it");
  CHECK(Said(three + PlanarEvent(2, "REAR")) ==
        "the scans are those on FRONT; there are lasers on LEFT, REAR, too: --laser-channel takes one of them");
  std::string many = PlanarEvent(1, "A");
  for (int i = 0; i < 1000; ++i) many += PlanarEvent(i, "B" + std::to_string(i));
  CHECK(Said(many).size() < 300);
}

TEST_CASE("scans whose utimes tell nothing get the times at which they were recorded, or numbers, and that is said") {
  const auto Log = [](std::int64_t period_us) {
    std::string log;
    for (int i = 0; i < 60; ++i) {
      bot_core::planar_lidar_t lidar = PlanarLidar(1'700'000'000 * (period_us > 0 ? 1 : 0));
      lidar.ranges[0] = 1.0f + 0.01f * static_cast<float>(i);
      log += Event("LASER", DataOf(lidar), 5'000'000 + i * period_us);
    }
    return log;
  };
  const Result recorded = Read(Log(50'000));
  REQUIRE(recorded.scans.size() == 60);
  CHECK(recorded.utimes()[59] == 5'000'000 + 59 * 50'000);
  CHECK(recorded.complaints == Lines{"LASER: 49 of the first 50 scans have the utime of the scan before: the times at "
                                     "which the scans were recorded are used instead"});
  const Result numbered = Read(Log(0));
  REQUIRE(numbered.scans.size() == 60);
  CHECK(numbered.utimes()[59] == 59 * 1'000'000);
  CHECK(numbered.complaints.at(0).find("the scans are numbered instead, as if one came every 1 s") !=
        std::string::npos);
}

TEST_CASE("utimes in milliseconds since 1970 are corrected, and those of the odometry with them") {
  std::string log;
  for (int i = 0; i < 60; ++i) {
    const std::int64_t utime_ms = 1'700'000'000'000 + 100 * i;
    log += OdometryEvent(utime_ms, 0.5 * i) + PlanarEvent(utime_ms);
  }
  const Result result = Read(log);
  REQUIRE(result.scans.size() == 60);
  CHECK(result.utimes()[7] == 1'700'000'000'700'000);
  CHECK(result.odometry_x_m[7] == 3.5);
  CHECK(result.complaints == Lines{"LASER: utime is in milliseconds: it is corrected"});
}

TEST_CASE(
    "where scans are recorded a sweep after their utime, that is of the first beam, and becomes that of the last") {
  const auto Log = [](std::int64_t lag_us) {
    std::string log;
    for (int i = 0; i < 60; ++i) {
      const std::int64_t utime = 5'000'000 + 100'000 * i;
      log += OdometryEvent(utime, 1e-6 * static_cast<double>(utime));
      log += Event("LASER", DataOf(PlanarLidar(utime)), utime + lag_us);
    }
    return log;
  };
  for (const double sweep_s : {0.1, -0.1}) {
    const LaserMessageOptions messages{.scan = {.sweep_s = sweep_s}};
    const Result first = Read(Log(104'000), {}, messages);
    CHECK(first.utimes()[7] == 5'800'000);
    CHECK(first.odometry_x_m[7] == Approx(5.8));
    CHECK(first.complaints ==
          Lines{"LASER: utime is that of a scan's first beam, as the times of recording show: 0.1 s are added"});
    const Result last = Read(Log(4'000), {}, messages);
    CHECK(last.utimes()[7] == 5'700'000);
    CHECK(last.complaints.empty());
  }
  CHECK(Read(Log(104'000)).utimes()[7] == 5'700'000);  // no sweep is said
}

TEST_CASE("a repeated utime is skipped and counted, one that goes back is kept") {
  const Result result = Read(PlanarEvent(3) + PlanarEvent(1) + PlanarEvent(3) + PlanarEvent(2));
  CHECK(result.utimes() == Utimes{3, 1, 2});
  CHECK(result.counts.at("utime_repeated") == 1);
}

TEST_CASE("where the clock begins anew, scans and odometry are those of the second drive") {
  constexpr std::int64_t kEnd = 20'000'000;
  std::string log;
  for (const std::int64_t utime : {std::int64_t{0}, kEnd}) log += OdometryEvent(utime, 1.0) + PlanarEvent(utime);
  for (const std::int64_t utime : {std::int64_t{0}, std::int64_t{50'000}, kEnd}) {
    log += OdometryEvent(utime, 5.0) + PlanarEvent(utime);
  }
  Result result = Read(log);
  CHECK(result.utimes() == Utimes{0, kEnd, 1, 50'000, kEnd + 1});
  CHECK(result.counts["utime_repeated"] == 0);
  CHECK(result.odometry_x_m == Odometries{1.0, 1.0, 5.0, 5.0, 5.0});
}

// What else a message can be wrong in is tested where it is checked: tests/unit/wire.
TEST_CASE("a bad laser message is counted and skipped") {
  bot_core::planar_lidar_t bad = PlanarLidar(2);
  bad.radstep = 0.0f;
  const std::string good = DataOf(PlanarLidar(2));
  for (const std::string& message : {DataOf(bad), good.substr(0, good.size() - 1), std::string()}) {
    const Result result = Read(PlanarEvent(1) + Event("LASER", message) + PlanarEvent(3));
    CHECK(result.utimes() == Utimes{1, 3});
    CHECK(result.counts.at("bad_message") == 1);
    CHECK(result.counts.at("bad_event") == 0);
  }
}

TEST_CASE("a damaged stretch of a log costs the events that it touches and no other") {
  const std::string first = PlanarEvent(1);
  const std::string second = PlanarEvent(2);
  const std::size_t event_bytes = first.size();

  const Result inserted = Read(first + "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx\xED\xA1\xDA" + second);
  CHECK(inserted.utimes() == Utimes{1, 2});
  CHECK(inserted.counts.at("bad_event") == 1);
  CHECK(Read("garbage" + first + second).utimes() == Utimes{1, 2});

  constexpr std::size_t kSyncWord = 0;
  constexpr std::size_t kChannelLength = 20;
  constexpr std::size_t kDataLength = 24;
  struct Damage {
    std::size_t at;
    std::string bytes;
  };
  for (const Damage& damage :
       {Damage{kSyncWord, "\xED\xA1\xDA\x02"}, Damage{kChannelLength, BigEndian(0, 4)},
        Damage{kChannelLength, BigEndian(1001, 4)}, Damage{kChannelLength, BigEndian(0xffffffff, 4)},
        Damage{kDataLength, BigEndian(event_bytes + 20, 4)},  // into the next event
        Damage{kDataLength, BigEndian(1 << 20, 4)},           // past the end
        Damage{kDataLength, BigEndian(0x04000001, 4)},        // beyond 64 MiB
        Damage{kDataLength, BigEndian(0xffffffff, 4)}}) {
    const Result result = Read(first + std::string(second).replace(damage.at, 4, damage.bytes) + PlanarEvent(3));
    CAPTURE(damage.at);
    CHECK(result.utimes() == Utimes{1, 3});
    CHECK(result.counts.at("bad_event") == 1);
    CHECK(result.counts.at("truncated") == 0);
  }
}

TEST_CASE("an event in which another seems to begin is read where the next one, or the end, shows that it is whole") {
  constexpr std::int64_t kLooksLikeAnEvent = 0xEDA1DA01;
  CHECK(Read(PlanarEvent(1) + PlanarEvent(kLooksLikeAnEvent)).utimes() == Utimes{1, kLooksLikeAnEvent});
  CHECK(Read(PlanarEvent(kLooksLikeAnEvent) + PlanarEvent(1)).utimes() == Utimes{kLooksLikeAnEvent, 1});
}

TEST_CASE("a log cut short anywhere gives the events that are whole") {
  const std::string second = PlanarEvent(2);
  for (std::size_t cut = 0; cut <= second.size(); ++cut) {
    CAPTURE(cut);
    const Result result = Read(PlanarEvent(1) + second.substr(0, cut));
    CHECK(result.utimes() == (cut == second.size() ? Utimes{1, 2} : Utimes{1}));
    CHECK(result.counts.at("truncated") == (cut > 0 && cut < second.size() ? 1 : 0));
    CHECK(result.counts.at("bad_event") == 0);
  }
  std::string log;
  for (int i = 0; i < 500; ++i) log += PlanarEvent(i * 7919);
  const std::string compressed = Compress(log);
  const Result half = Read(compressed.substr(0, compressed.size() / 2));
  CHECK(half.scans.size() > 100);
  CHECK(half.scans.size() < 500);
  CHECK(half.counts.at("truncated") == 1);
}

TEST_CASE("a file of nothing but headers that promise much is read in no time") {
  std::string hostile = PlanarEvent(1);
  const std::string header =
      BigEndian(0xEDA1DA01, 4) + std::string(16, '\0') + BigEndian(4, 4) + BigEndian(64 << 20, 4);
  for (int i = 0; i < 100000; ++i) hostile += header;
  CHECK(Read(hostile + PlanarEvent(2)).utimes() == Utimes{1, 2});
}

TEST_CASE("a log without a laser is an error that lists its channels") {
  const std::string log = Event("IMU", "12345678") + Event("ODO\nMETRY", "") + Event("IMU", "1");
  CHECK(ErrorOfLog(log).ends_with("; its channels: IMU (2), ODO?METRY (1)"));
  CHECK(ErrorOfLog(log + PlanarEvent(1, "FRONT"), {"REAR"})
            .ends_with(" on channel REAR; its channels: FRONT (1, laser), IMU (2), ODO?METRY (1)"));
  CHECK(ErrorOfLog(log + PlanarEvent(1), {"LASR"}).ends_with("; did you mean LASER?"));
  CHECK(ErrorOfLog(log + PlanarEvent(1), {"IMUS"}).ends_with("ODO?METRY (1)"));  // IMU is near, but no laser
  CHECK(ErrorOfLog(PlanarEvent(1, "LA\nSER"), {"LASER"}).ends_with("; did you mean LA?SER?"));
  std::string many;
  for (int i = 0; i < 3000; ++i) many += Event("C" + std::to_string(10000 + i), "x");
  CHECK(ErrorOfLog(many).ends_with("C10019 (1), and 980 more"));
  CHECK(ErrorOfLog(PlanarEvent(1).substr(0, 50)).ends_with("its channels: none"));
}

TEST_CASE("the kind of a log is found from its content, not from its name") {
  const std::string carmen = "# a log\nODOM 1\nFLASER 2 1 1 0 0 0 0 0 0 1.5 host 1.5\n";
  for (const auto& [content, utime] :
       {std::pair(carmen, 1500000), std::pair(Compress(carmen), 1500000), std::pair(PlanarEvent(8), 8),
        std::pair(Compress(PlanarEvent(8)), 8), std::pair("damage" + PlanarEvent(8), 8)}) {
    const ScratchFile file(content);
    CHECK(OpenLaserSource(file.path(), {})->Next()->utime == utime);
  }
}

TEST_CASE("the options of a source reach it, and a world file is a source too") {
  const ScratchFile log(PlanarEvent(1, "FRONT") + PlanarEvent(2, "REAR"));
  CHECK(OpenLaserSource(log.path(), {0, {"REAR"}})->Next()->utime == 2);
  CHECK(OpenLaserSource("sim:demo", {1, {}})->Next() == OpenLaserSource("sim:demo", {1, {}})->Next());
  CHECK(OpenLaserSource("sim:demo", {1, {}})->Next() != OpenLaserSource("sim:demo", {2, {}})->Next());
  const ScratchFile world("box 0 0 4 3\nspeed 1 1\nlaser 90 10 8 10 0\nwaypoint 1 1\nwaypoint 2 1\n");
  CHECK(OpenLaserSource("sim:" + world.path(), {})->Next()->ranges_m.size() == 10);
}

TEST_CASE("two drivers of ROS on one channel are told apart by their frames, and one of them is chosen") {
  std::string log;
  for (int sec = 1; sec <= 4; ++sec) {
    sensor_msgs::LaserScan scan{};
    scan.header.stamp.sec = sec;
    scan.header.frame_id = sec % 2 == 0 ? "/rear" : "front";
    scan.angle_increment = 0.5f;
    scan.ranges = {1.0f, 2.0f, 3.0f};
    scan.ranges_length = 3;
    log += Event("SCAN", DataOf(scan));
  }
  CHECK(ErrorOfLog(log) == ": SCAN: the scans are of several lasers: --laser-frame must name one of front, rear");
  CHECK(ErrorOfLog(log, {"", "font"}).starts_with(": SCAN: no scan has the frame font"));
  const Result rear = Read(log, {"", "rear"});
  CHECK(rear.utimes() == Utimes{2'000'000, 4'000'000});
  CHECK(rear.counts.at("other_frame") == 2);
  CHECK(rear.complaints.empty());
}

TEST_CASE("a frame that no scan can have is refused") {
  const auto Refuses = [](const std::string& source) {
    return ErrorOf([&] { OpenLaserSource(source, {0, {"", "front"}}); }).find("remove") != std::string::npos;
  };
  CHECK(Refuses(ScratchFile(PlanarEvent(1)).path()));
  CHECK(Refuses(ScratchFile("FLASER 2 1 1 0 0 0 0 0 0 1.5 host 1.5\n").path()));
  CHECK(Refuses("sim:demo"));
}

TEST_CASE("a source that cannot be opened is an error of one line") {
  const auto error_of = [](const std::string& name) { return ErrorOf([&] { OpenLaserSource(name, {}); }); };
  CHECK(error_of("no_such.log") == "there is no file no_such.log");
  CHECK(error_of("sim:no_such").find("the built-in worlds are arena, block, corridor, demo") != std::string::npos);
  const ScratchFolder empty;
  const std::string directory = empty.path().string();
  CHECK(error_of(directory).starts_with(directory + " is a directory without a bag of ROS 2"));
  const std::string pipe = ScratchPath();
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(error_of(pipe).starts_with(pipe + " is no regular file"));
  std::filesystem::remove(pipe);
  const std::string neither =
      " is neither a CARMEN log (no FLASER or ROBOTLASER1 line in its first 10000 lines) nor an LCM log, nor a bag of "
      "ROS or MCAP";
  for (const auto& [content, error] :
       {std::pair(std::string(), std::string(" is empty")), std::pair(Compress(""), std::string(" is empty")),
        std::pair(Compress("FLASER").substr(0, 10), std::string(" is a damaged gzip file")),
        std::pair(std::string("hello\n"), neither), std::pair(std::string("# FLASER\n XFLASER 2\n"), neither),
        std::pair(std::string(3 << 20, '\0'), neither)}) {
    const ScratchFile file(content);
    CHECK(error_of(file.path()).starts_with(file.path() + error));
  }
}

TEST_CASE("a log whose scans turn against its own poses is complained of, with the flag that mends it") {
  const auto ComplaintsOf = [](bool poses_of_mbot, double sense, const LaserMessageOptions& messages) {
    std::string log;
    for (int k = 0; k < 30; ++k) {
      const double yaw_rad = WrapAngle(0.15 * k);
      botlab::lidar_t lidar{};
      lidar.utime = 1'000'000 + 100'000 * k;
      for (int i = 0; i < 300; ++i) {  // a wall on one side, 1 m away, and one on the other, 2 m away
        const double angle_rad = 2.0 * kPi * i / 300;
        const double y = std::sin(angle_rad + yaw_rad);
        lidar.thetas.push_back(static_cast<float>(sense > 0.0 ? angle_rad : 2.0 * kPi - angle_rad));
        lidar.ranges.push_back(static_cast<float>(std::min(6.0, (y > 0.0 ? 1.0 : 2.0) / std::abs(y))));
      }
      lidar.num_ranges = 300;
      lidar.times.resize(300);
      lidar.intensities.resize(300);
      const mbot_lcm_msgs::pose2D_t pose{lidar.utime, 0.0f, 0.0f, static_cast<float>(yaw_rad)};
      const auto odometry = ToMessage(Odometry{lidar.utime, Pose2{0.0, 0.0, yaw_rad}});
      log += Event("LIDAR", DataOf(lidar)) +
             (poses_of_mbot ? Event("SLAM_POSE", DataOf(pose)) : Event("ODOMETRY", DataOf(odometry)));
    }
    const ScratchFile file(log);
    LcmLogSource source(file.path(), {}, messages);
    ReadAll(source);
    return source.Complaints();
  };
  CHECK(ComplaintsOf(true, -1.0, {}).empty());
  CHECK(ComplaintsOf(false, -1.0, {}).empty());
  CHECK(ComplaintsOf(true, 1.0, {.botlab_clockwise = false}).empty());
  CHECK(ComplaintsOf(true, 1.0, {}) == Lines{"the scans on LIDAR turn in the opposite direction to the poses on "
                                             "SLAM_POSE: the map is a mirror image: add --no-botlab-clockwise"});
  CHECK(ComplaintsOf(false, -1.0, {.botlab_clockwise = false}).at(0).ends_with("remove --no-botlab-clockwise"));
}

TEST_CASE("the real LCM log has the sweeps that its description says, and no other sense of rotation", "[logs]") {
  const auto path = FindRealLog("lcm/mbot_convex.lcmlog.gz");
  if (!path) return;
  for (const bool clockwise : {true, false}) {
    LcmLogSource source(*path, {}, {.botlab_clockwise = clockwise});
    const auto scans = ReadAll(source);
    CHECK(source.Complaints().empty() == clockwise);
    if (!clockwise) continue;
    CHECK(scans.size() == 459);
    CHECK(source.Counts() == std::map<std::string, std::int64_t>{{"bad_event", 0}, {"truncated", 0}});
    // Its first beams, as another LCM decoder shows them: 0.90125 m at 6.26873 rad, 0.9015 m at 0.00790852 rad.
    CHECK(scans[0].utime == 1447367745557463 + 149933);  // of its last beam
    CHECK(scans[0].ranges_m[0] == 0.90125f);
    CHECK(scans[0].ranges_m[5] == 0.9015f);
  }
}

}  // namespace crsm
