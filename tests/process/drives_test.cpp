// Several drives on one map: logs that are given together, a clock that begins anew inside a log, and a robot that
// stands elsewhere when its map goes on; in one process and in many.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

#include "catch.hpp"
#include "common/metrics/trajectory_error.hpp"
#include "processes.hpp"
#include "services/sources/open_laser_source.hpp"
#include "services/wire/conversions.hpp"
#include "services/wire/event_log_writer.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNumScans = 3251;  // of sim:demo

/// A part of a drive through sim:demo, on a day of its own.
struct Drive {
  std::vector<LaserScan> scans;
  std::vector<Pose2> truth;
};

Drive TakeDrive(std::uint64_t seed, std::size_t first, std::size_t last) {
  const auto source = OpenLaserSource("sim:demo", {seed});
  Drive drive;
  for (std::size_t i = 0; i < last; ++i) {
    auto scan = source->Next();
    REQUIRE(scan);
    if (i < first) continue;
    drive.scans.push_back(std::move(*scan));
    drive.truth.push_back(source->TruePose().value());
  }
  return drive;
}

/// The n-th pose of a run is that of the n-th scan of all logs, and so is the true one.
double MeanError_m(const fs::path& results, const std::vector<Pose2>& true_poses) {
  Trajectory poses = ReadTrajectory(results / "trajectory.tum");
  REQUIRE(poses.size() == true_poses.size());
  Trajectory truth;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].utime = static_cast<std::int64_t>(i);
    truth.push_back({static_cast<std::int64_t>(i), true_poses[i]});
  }
  return EvaluateTrajectory(Align(poses, truth), truth).mean_m;
}

/// Two logs on one map: what slam_offline says of them, and the mean error of the poses [m].
std::pair<std::string, double> MapBoth(const Drive& first, const Drive& second) {
  const TemporaryFolder folder;
  const std::string log = folder.Write(first.scans, "first");
  const Ended ended = folder.Run("slam_offline", {log, folder.Write(second.scans, "second"), "--out", folder / "out"});
  CHECK(ended.exit_code == 0);
  std::vector<Pose2> truth = first.truth;
  truth.insert(truth.end(), second.truth.begin(), second.truth.end());
  return {ended.errors, MeanError_m(folder / "out", truth)};
}

}  // namespace

TEST_CASE("five drives through one flat with one clock, out of order, are one map within 0.05 m") {
  const TemporaryFolder folder;
  std::vector<Drive> drives;
  for (std::size_t i = 0; i < 5; ++i) {
    const std::size_t first = i * kNumScans * 15 / 100;  // each has 40 % of the way
    drives.push_back(TakeDrive(i + 1, first, first + kNumScans * 40 / 100));
    folder.Write(drives.back().scans, std::to_string(i));
  }
  for (const auto& order : std::vector<std::vector<std::size_t>>{{2, 3, 4, 0, 1}, {0, 2, 1, 4, 3}, {1, 0, 4, 2, 3}}) {
    CAPTURE(order);
    std::vector<std::string> later{"--force"};
    std::vector<Pose2> truth;
    for (const std::size_t i : order) {
      if (i != order.front()) later.push_back(folder / std::to_string(i));
      truth.insert(truth.end(), drives[i].truth.begin(), drives[i].truth.end());
    }
    const Ended ended = folder.Map(folder / std::to_string(order.front()), "out", later);
    INFO(ended.output << ended.errors);
    for (std::size_t i = 0; i < 5; ++i) {
      CHECK(ended.output.find((folder / std::to_string(i)).string() + ": 1300 of 1300 scans are on the map") !=
            std::string::npos);
    }
    CHECK(ended.errors.find("utime_repeated") == std::string::npos);
    CHECK(MeanError_m(folder / "out", truth) < 0.05);
  }
}

TEST_CASE("drives in two buildings stay apart, and the map is that of the larger one") {
  const TemporaryFolder folder;
  const Ended ended = folder.Map("sim:rooms", "out", {"sim:demo"});
  const bool one = ended.output.find("sim:rooms: 0 of ") != std::string::npos;
  const bool other = ended.output.find("sim:demo: 0 of ") != std::string::npos ||
                     ended.output.find("sim:demo: 1 of ") != std::string::npos;
  INFO(ended.output);
  CHECK(one != other);
  CHECK(ended.output.find("the map is good") == std::string::npos);
}

TEST_CASE("a run over two logs that was interrupted in the second is finished by both with --resume") {
  const TemporaryFolder folder;
  const Drive one = TakeDrive(1, 0, 700);
  const Drive other = TakeDrive(2, 100, 600);
  const std::string first = folder.Write(one.scans, "one");
  const std::string second = folder.Write(other.scans, "other");
  folder.Map(first, "whole", {second});
  folder.Map(first, "out", {folder.Write({other.scans.begin(), other.scans.begin() + 250}, "part_other")});
  const Ended ended = folder.Map(first, "out", {second, "--resume", folder / "out"});
  CHECK(ended.errors.find("one: 700 scans were in the map already") != std::string::npos);
  CHECK(ended.errors.find("other: 250 scans were in the map already") != std::string::npos);
  folder.CheckSame("out", "whole");
}

TEST_CASE("each of several logs is searched on the whole of a finished map") {
  const TemporaryFolder folder;
  folder.Map("sim:demo", "map");
  std::vector<Pose2> truth;
  std::vector<std::string> logs;
  for (const std::size_t first : {std::size_t{2000}, std::size_t{300}}) {
    const Drive drive = TakeDrive(first, first, first + 200);
    logs.push_back(folder.Write(drive.scans, std::to_string(first)));
    truth.insert(truth.end(), drive.truth.begin(), drive.truth.end());
  }
  folder.Map(logs[0], "out", {logs[1], "--localize", folder / "map"});
  CHECK(MeanError_m(folder / "out", truth) < 0.05);
}

TEST_CASE("one wrong log among several is named before anything is mapped") {
  const TemporaryFolder folder;
  const std::string good = folder.Write(TakeDrive(1, 0, 50).scans, "good");
  const std::string wrong = folder / "wrong";
  const std::string no_scans = folder / "no_scans";
  std::ofstream(wrong) << "no log\n";
  std::ofstream(no_scans) << "FLASER 2 1\n";
  struct Case {
    std::vector<std::string> words;
    std::string expected;
    int exit_code;
  };
  for (Case one :
       std::vector<Case>{{{good, wrong}, wrong + " is neither a CARMEN log", 1},
                         {{good, folder / "absent"}, "there is no file " + (folder / "absent").string(), 1},
                         {{good, no_scans}, no_scans + " has no scans", 1},
                         {{good, "sim:demo", good}, good + ": is given twice", 2},
                         {{good, "hokuyo:/dev/null"}, "hokuyo:/dev/null: a laser can only be mapped alone", 2},
                         {{good, "sim:demo", "--no-loops"}, "several logs are joined by loops", 2},
                         {{good, "sim:demo", "--localize", folder / "map", "--start", "1,2,3"}, "--start: ", 2}}) {
    one.words.insert(one.words.end(), {"--out", folder / "out"});
    folder.CheckRefused("slam_offline", one.words, one.expected, one.exit_code);
    CHECK_FALSE(fs::exists(folder / "out"));
  }
}

TEST_CASE("where the clock of a log begins anew nothing is left out and a line says so, in one process and in many") {
  const TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeDrive(1, 0, 300).scans;
  const Drive elsewhere = TakeDrive(2, 100, 400);
  const std::int64_t back_us = elsewhere.scans.front().utime - scans.front().utime;
  for (const LaserScan& scan : elsewhere.scans) {
    scans.push_back(scan);
    scans.back().utime -= back_us;
  }
  const std::string log = folder.Write(scans, "restart");
  for (const Ended& ended : {folder.Map(log, "alone"), folder.MapWithStack(log, "stack")}) {
    CHECK(ended.errors.find("at scan 301: unless the robot stands where it stood, a new trajectory begins") !=
          std::string::npos);
  }
  folder.CheckSame("stack", "alone");
  const Trajectory poses = ReadTrajectory(folder / "alone/trajectory.tum");
  REQUIRE(poses.size() == 600);
  CHECK(poses[300].utime == poses[0].utime + 1);
}

TEST_CASE("a log that begins soon behind another one, but elsewhere, is a drive of its own") {
  const Drive first = TakeDrive(1, 0, 1500);
  Drive second = TakeDrive(2, 0, 900);
  const std::int64_t later_us = first.scans.back().utime + 3'000'000 - second.scans.front().utime;
  for (LaserScan& scan : second.scans) scan.utime += later_us;
  const auto [said, error_m] = MapBoth(first, second);
  CHECK(said.find("second: is not where the log before it ends: a drive of its own") != std::string::npos);
  CHECK(error_m < 0.05);
}

TEST_CASE(
    "several robots in one log are drives of their own, as in logs of their own, where their channels are named") {
  const TemporaryFolder folder;
  const Drive one = TakeDrive(1, 0, 900);
  const Drive other = TakeDrive(2, 100, 900);
  const std::string both = folder / "both";
  {
    EventLogWriter log(both);
    for (std::size_t i = 0; i < one.scans.size(); ++i) {
      log.Write("ONE", ToMessage(one.scans[i]));
      if (i < other.scans.size()) log.Write("OTHER", ToMessage(other.scans[i]));
    }
    log.Flush();
  }
  folder.Map(folder.Write(one.scans, "one"), "apart", {folder.Write(other.scans, "other")});
  const Ended ended = folder.Map(both, "together", {"--laser-channel", "ONE,OTHER"});
  CHECK(ended.output.find("both (ONE): 900 of 900 scans are on the map") != std::string::npos);
  CHECK(ended.output.find("both (OTHER): ") != std::string::npos);
  for (const char* name : {"map.pgm", "trajectory.tum"}) {
    CHECK(ReadFile(folder / "together" / name) == ReadFile(folder / "apart" / name));
  }
  const Ended wrong = folder.Run("slam_offline", {both, "--laser-channel", "ONE,TWO", "--out", folder / "wrong"});
  CHECK(wrong.exit_code == 1);
  CHECK(wrong.errors.find("TWO") != std::string::npos);
}

TEST_CASE("each of several logs may have a number of its own for no return") {
  const Drive first = TakeDrive(1, 0, 900);
  Drive second = TakeDrive(2, 0, 900);
  int num = 0;
  for (LaserScan& scan : second.scans) {
    for (float& range_m : scan.ranges_m) {
      if (range_m > 4.0f || ++num % 5 == 0) range_m = 4.095f;
    }
  }
  const auto [said, error_m] = MapBoth(first, second);
  CHECK(said.find("not taken for hits in this log") != std::string::npos);
  CHECK(error_m < 0.05);
}

TEST_CASE(
    "a robot that stands elsewhere when its map goes on is found there, from a hint too, by one process or many") {
  const TemporaryFolder folder;
  folder.Map(folder.Write(TakeDrive(1, 0, 1500).scans, "monday"), "map");
  Drive tuesday = TakeDrive(2, 500, 900);
  const std::int64_t day_us = 1'000'000 * std::int64_t{86'400};
  for (LaserScan& scan : tuesday.scans) scan.utime += day_us;
  const std::string log = folder.Write(tuesday.scans, "tuesday");
  const Pose2& at = tuesday.truth.front();
  for (const auto& hint :
       {std::string(), fmt::format("{:.2f},{:.2f},{:.2f}", at.x_m + 0.4, at.y_m, at.yaw_rad - 0.1)}) {
    CAPTURE(hint);
    std::vector<std::string> flags{"--resume", folder / "map"};
    if (!hint.empty()) flags.insert(flags.end(), {"--start", hint});
    for (const char* out : {"out", "stack"}) fs::remove_all(folder / out);
    const Ended ended = folder.Map(log, "out", flags);
    CHECK(ended.output.find("tuesday: 400 of 400 scans are on the map") != std::string::npos);
    Trajectory poses = ReadTrajectory(folder / "out/trajectory.tum");
    REQUIRE(poses.size() == 1900);
    double largest_m = 0.0;
    for (std::size_t i = 0; i < 400; ++i) {
      largest_m = std::max(largest_m, Length(Inverse(tuesday.truth[i]) * poses[1500 + i].T_map_laser));
    }
    CHECK(largest_m < 0.1);
    folder.MapWithStack(log, "stack", flags);
    folder.CheckSame("stack", "out");
  }
}
