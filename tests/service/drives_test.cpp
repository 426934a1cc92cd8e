// Several drives on one map: logs that are given together, a clock that begins anew inside a log, and a robot that
// stands elsewhere when its map goes on; in one process and in many.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "catch.hpp"
#include "common/metrics/trajectory_error.hpp"
#include "processes.hpp"
#include "services/sources/open_laser_source.hpp"
#include "source_helpers.hpp"

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

struct Ended {
  int exit_code;
  std::string said;
  std::string errors;
};

Ended Map(const TemporaryFolder& folder, std::vector<std::string> words) {
  Process process("slam_offline", std::move(words), folder / "log");
  const int exit_code = process.AwaitExit();
  return {exit_code, process.output(), process.errors()};
}

Ended MapWithStack(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.end(), {"--lcm-url", MakeBusUrl()});
  Process process(CRSM_SOURCE_DIR "/scripts/run_stack", std::move(words), folder / "log");
  const int exit_code = process.AwaitExit();
  return {exit_code, process.output(), process.errors()};
}

void CheckSameMap(const fs::path& one, const fs::path& other) {
  for (const char* file : {"map.png", "trajectory.tum"}) {
    INFO(file);
    CHECK_FALSE(ReadFile(one / file).empty());
    CHECK(ReadFile(one / file) == ReadFile(other / file));
  }
}

std::size_t CountLines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
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

}  // namespace

TEST_CASE("five drives through one flat with one clock, out of order, are one map within 0.05 m") {
  const TemporaryFolder folder;
  std::vector<Drive> drives;
  for (std::size_t i = 0; i < 5; ++i) {
    const std::size_t first = i * kNumScans * 15 / 100;  // each has 40 % of the way
    drives.push_back(TakeDrive(i + 1, first, first + kNumScans * 40 / 100));
    WriteScans(drives.back().scans, folder / std::to_string(i));
  }
  for (const auto& order : std::vector<std::vector<std::size_t>>{{2, 3, 4, 0, 1}, {0, 2, 1, 4, 3}, {1, 0, 4, 2, 3}}) {
    CAPTURE(order);
    std::vector<std::string> words{"--force", "--out", folder / "out"};
    std::vector<Pose2> truth;
    for (const std::size_t i : order) {
      words.push_back((folder / std::to_string(i)).string());
      truth.insert(truth.end(), drives[i].truth.begin(), drives[i].truth.end());
    }
    const Ended ended = Map(folder, words);
    INFO(ended.said << ended.errors);
    REQUIRE(ended.exit_code == 0);
    for (std::size_t i = 0; i < 5; ++i) {
      CHECK(ended.said.find((folder / std::to_string(i)).string() + ": 1300 of 1300 scans are on the map") !=
            std::string::npos);
    }
    CHECK(ended.errors.find("utime_repeated") == std::string::npos);
    CHECK(MeanError_m(folder / "out", truth) < 0.05);
  }
}

TEST_CASE("drives in two buildings stay apart, and the map is that of the larger one") {
  const TemporaryFolder folder;
  const Ended ended = Map(folder, {"sim:rooms", "sim:demo", "--out", folder / "out"});
  REQUIRE(ended.exit_code == 0);
  const bool one = ended.said.find("sim:rooms: 0 of ") != std::string::npos;
  const bool other = ended.said.find("sim:demo: 0 of ") != std::string::npos ||
                     ended.said.find("sim:demo: 1 of ") != std::string::npos;
  INFO(ended.said);
  CHECK(one != other);
  CHECK(ended.said.find("the map is good") == std::string::npos);
}

TEST_CASE("a run over two logs that was interrupted in the second is finished by both with --resume") {
  const TemporaryFolder folder;
  const Drive one = TakeDrive(1, 0, 700);
  const Drive other = TakeDrive(2, 100, 600);
  WriteScans(one.scans, folder / "one");
  WriteScans(other.scans, folder / "other");
  REQUIRE(Map(folder, {folder / "one", folder / "other", "--out", folder / "whole"}).exit_code == 0);
  WriteScans({other.scans.begin(), other.scans.begin() + 250}, folder / "part_other");
  REQUIRE(Map(folder, {folder / "one", folder / "part_other", "--out", folder / "out"}).exit_code == 0);
  const Ended ended =
      Map(folder, {folder / "one", folder / "other", "--out", folder / "out", "--resume", folder / "out"});
  REQUIRE(ended.exit_code == 0);
  CHECK(ended.errors.find("one: 700 scans were in the map already") != std::string::npos);
  CHECK(ended.errors.find("other: 250 scans were in the map already") != std::string::npos);
  CheckSameMap(folder / "out", folder / "whole");
}

TEST_CASE("each of several logs is searched on the whole of a finished map") {
  const TemporaryFolder folder;
  REQUIRE(Map(folder, {"sim:demo", "--out", folder / "map"}).exit_code == 0);
  std::vector<Pose2> truth;
  std::vector<std::string> words{"--out", folder / "out", "--localize", folder / "map"};
  for (const std::size_t first : {std::size_t{2000}, std::size_t{300}}) {
    const Drive drive = TakeDrive(first, first, first + 200);
    WriteScans(drive.scans, folder / std::to_string(first));
    truth.insert(truth.end(), drive.truth.begin(), drive.truth.end());
    words.push_back((folder / std::to_string(first)).string());
  }
  REQUIRE(Map(folder, words).exit_code == 0);
  CHECK(MeanError_m(folder / "out", truth) < 0.05);
}

TEST_CASE("one wrong log among several is named before anything is mapped") {
  const TemporaryFolder folder;
  WriteScans(TakeDrive(1, 0, 50).scans, folder / "good");
  std::ofstream(folder / "wrong") << "no log\n";
  std::ofstream(folder / "no_scans") << "FLASER 2 1\n";
  const auto CheckRefused = [&](std::vector<std::string> words, const std::string& expected, int exit_code) {
    words.insert(words.end(), {"--out", folder / "out"});
    const Ended ended = Map(folder, words);
    INFO(ended.errors);
    CHECK(ended.exit_code == exit_code);
    CHECK(ended.errors.find(expected) != std::string::npos);
    CHECK(CountLines(ended.errors) == 1);
    CHECK_FALSE(fs::exists(folder / "out"));
  };
  CheckRefused({folder / "good", folder / "wrong"}, (folder / "wrong").string() + " is neither a CARMEN log", 1);
  CheckRefused({folder / "good", folder / "absent"}, "there is no file " + (folder / "absent").string(), 1);
  CheckRefused({folder / "good", folder / "no_scans"}, (folder / "no_scans").string() + " has no scans", 1);
  CheckRefused({folder / "good", "sim:demo", folder / "good"}, (folder / "good").string() + ": is given twice", 2);
  CheckRefused({folder / "good", "hokuyo:/dev/null"}, "hokuyo:/dev/null: a laser can only be mapped alone", 2);
  CheckRefused({folder / "good", "sim:demo", "--no-loops"}, "several logs are joined by loops", 2);
  CheckRefused({folder / "good", "sim:demo", "--localize", folder / "map", "--start", "1,2,3"}, "--start: ", 2);
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
  WriteScans(scans, folder / "restart");
  const std::string expected = "at scan 301: unless the robot stands where it stood, a new trajectory begins";

  const Ended alone = Map(folder, {folder / "restart", "--out", folder / "alone"});
  REQUIRE(alone.exit_code == 0);
  CHECK(alone.errors.find(expected) != std::string::npos);
  const Trajectory poses = ReadTrajectory(folder / "alone/trajectory.tum");
  REQUIRE(poses.size() == 600);
  CHECK(poses[300].utime == poses[0].utime + 1);

  const Ended stack = MapWithStack(folder, {folder / "restart", "--out", folder / "stack"});
  REQUIRE(stack.exit_code == 0);
  CHECK(stack.errors.find(expected) != std::string::npos);
  CheckSameMap(folder / "stack", folder / "alone");
}

TEST_CASE(
    "a robot that stands elsewhere when its map goes on is found there, from a hint too, by one process or many") {
  const TemporaryFolder folder;
  WriteScans(TakeDrive(1, 0, 1500).scans, folder / "monday");
  Drive tuesday = TakeDrive(2, 500, 900);
  const std::int64_t day_us = 1'000'000 * std::int64_t{86'400};
  for (LaserScan& scan : tuesday.scans) scan.utime += day_us;
  WriteScans(tuesday.scans, folder / "tuesday");
  REQUIRE(Map(folder, {folder / "monday", "--out", folder / "map"}).exit_code == 0);
  const Pose2& at = tuesday.truth.front();
  for (const auto& hint :
       {std::string(), fmt::format("{:.2f},{:.2f},{:.2f}", at.x_m + 0.4, at.y_m, at.yaw_rad - 0.1)}) {
    CAPTURE(hint);
    std::vector<std::string> words{folder / "tuesday", "--out", folder / "out", "--resume", folder / "map"};
    fs::remove_all(folder / "out");
    if (!hint.empty()) words.insert(words.end(), {"--start", hint});
    const Ended ended = Map(folder, words);
    REQUIRE(ended.exit_code == 0);
    CHECK(ended.said.find("tuesday: 400 of 400 scans are on the map") != std::string::npos);
    Trajectory poses = ReadTrajectory(folder / "out/trajectory.tum");
    REQUIRE(poses.size() == 1900);
    double largest_m = 0.0;
    for (std::size_t i = 0; i < 400; ++i) {
      largest_m = std::max(largest_m, Length(Inverse(tuesday.truth[i]) * poses[1500 + i].T_map_laser));
    }
    CHECK(largest_m < 0.1);
    words[2] = (folder / "stack").string();
    fs::remove_all(folder / "stack");
    REQUIRE(MapWithStack(folder, words).exit_code == 0);
    CheckSameMap(folder / "stack", folder / "out");
  }
}
