#include "common/slam.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "catch.hpp"
#include "check_pose.hpp"
#include "common/diagnosis/verdict.hpp"
#include "common/worlds/simulator.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// Where the laser is at the k-th scan: along a bend of 1 m, 4 cm and 1.1 degrees a scan.
Pose2 TruePose(int k) { return {2.0 * std::sin(0.02 * k), 2.0 * (1.0 - std::cos(0.02 * k)), 0.02 * k}; }

std::vector<Slam::Step> DriveSteps(Slam& slam, int num_scans = 25) {
  std::vector<Slam::Step> steps;
  for (int k = 0; k < num_scans; ++k) steps.push_back(slam.Process(ScanRoom(TruePose(k), 1000 + 100 * k, 180)));
  return steps;
}

std::vector<ScanMatch> Drive(Slam& slam, int num_scans = 25) {
  std::vector<ScanMatch> matches;
  for (const Slam::Step& step : DriveSteps(slam, num_scans)) matches.push_back(step.match);
  return matches;
}

/// Two halls and 40 m of smooth walls between them, of which a laser with a reach of 10 m sees no end for 20 m.
World MakeBareCorridor() {
  return ParseWorld(R"(
      laser 180 180 10 5 0.01
      speed 0.4 0.6
      wall 0 0 40 0
      wall 0 2.4 40 2.4
      wall 0 0 0 -3
      wall 0 -3 -8 -3
      wall -8 -3 -8 6
      wall -8 6 0 6
      wall 0 6 0 2.4
      wall 40 0 40 -3
      wall 40 -3 49 -3
      wall 49 -3 49 7
      wall 49 7 40 7
      wall 40 7 40 2.4
      box -6 3 1 1
      box -4 -2.5 1.5 0.6
      box 43 -2 1 1
      box 45 4 1.3 0.7
      box 46.5 0 0.5 0.5
      waypoint -5 -0.5
      waypoint -2 1.2
      waypoint 44 1.2
      waypoint 46.5 3
      waypoint 43 5)",
                    "bare corridor");
}

/// A drive through it: in the middle the robot stands for five seconds, and goes on twice as fast for ten metres.
struct BareCorridorDrive {
  RunStatistics statistics;
  Pose2 error;  ///< of the last scan
  int num_degenerate = 0;
};

BareCorridorDrive DriveThroughBareCorridor(std::uint64_t seed, Slam& slam, std::optional<double> wheels_scale) {
  constexpr int kMiddle = 340;  // the scan: 20 m into the corridor
  constexpr int kFast = 125;    // scans, every second of which is left out
  BareCorridorDrive drive;
  Simulator simulator(MakeBareCorridor(), seed);
  Simulator with_other_noise(MakeBareCorridor(), seed + 1000);  // at the same places
  Random random(seed);
  Pose2 odometry{5.0, -3.0, 1.0};
  Pose2 last;
  std::int64_t utime = 1'000'000;
  const auto See = [&](LaserScan scan) {
    Pose2 motion = Inverse(last) * *simulator.TruePose();
    last = *simulator.TruePose();
    if (motion != Pose2{}) motion.x_m = wheels_scale.value_or(1.0) * motion.x_m + 0.002 * random.Gaussian();
    odometry = odometry * motion;
    scan.utime = utime += 200'000;
    const Slam::Step step = slam.Process(scan, wheels_scale ? std::optional(odometry) : std::nullopt);
    drive.statistics.Add(scan.utime, step.scan.rays);
    drive.statistics.Add(step.match);
    drive.num_degenerate += step.match.state == MatchState::kDegenerate;
    drive.error = Inverse(last) * step.match.T_map_laser;
  };
  for (int k = 0;; ++k) {
    const auto scan = simulator.Next();
    const auto other = with_other_noise.Next();
    if (!scan) return drive;
    if (k > kMiddle && k < kMiddle + kFast && k % 2 == 0) continue;
    See(*scan);
    for (int i = 0; k == kMiddle && i < 25; ++i) See(i % 2 == 0 ? *other : *scan);
  }
}

}  // namespace

TEST_CASE("a drive around a room is followed to within a cell, and its map is the room") {
  Slam slam(TestParameters());
  const auto history = Drive(slam);
  REQUIRE(history.size() == 25);
  CHECK(history.front().state == MatchState::kFirst);
  for (int k = 0; k < 25; ++k) {
    CAPTURE(k);
    const ScanMatch& match = history[static_cast<std::size_t>(k)];
    CHECK(match.utime == 1000 + 100 * k);
    CHECK(match.map_version == k);
    CheckPose(match.T_map_laser, TruePose(k), 0.05);
  }
  const DenseGrid grid = slam.map().ToDenseGrid();
  CHECK(std::abs(grid.width_cells - 142) <= 2);  // the room's, and a cell at each wall
  CHECK(std::abs(grid.height_cells - 102) <= 2);
  CHECK(slam.map().At({0, 0}) > 200);
  CHECK(grid.cell_size_m == 0.05);
}

TEST_CASE("the paper's way follows the drive to within two of its cells") {
  Parameters parameters = TestParameters();
  parameters.update.algorithm = Algorithm::kPaper;
  parameters.loops.loops = false;
  Slam slam(parameters);
  CheckPose(Drive(slam).back().T_map_laser, TruePose(24), 0.1);
}

TEST_CASE(
    "as shipped, a robot in a bare corridor is where its wheels say; without wheels its map is no good, and says so") {
  const bool has_wheels = GENERATE(true, false);
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    CAPTURE(has_wheels, seed);
    Parameters parameters;
    parameters.scan.range_max_m = 10.6;  // the laser's reach is 95 % of it
    parameters.match.seed = seed;
    Slam slam(parameters);
    const BareCorridorDrive drive =
        DriveThroughBareCorridor(seed, slam, has_wheels ? std::optional(1.01) : std::nullopt);
    if (has_wheels) {
      CHECK(drive.num_degenerate > 300);
      CHECK(Length(drive.error) < 0.4);  // as far as the wheels, on 40 m, also where it stands or hurries
      continue;
    }
    CHECK(Length(drive.error) > 1.0);  // else there is nothing to say
    const Verdict verdict = Judge(drive.statistics, slam.map(), slam.mapper().FindPiecesAndError());
    for (const std::string& line : FormatVerdict(verdict)) UNSCOPED_INFO(line);
    CHECK(verdict.trust != Trust::kGood);
  }
}

TEST_CASE("constants of a slam reach what they are of") {
  const auto NumRays = [](const Slam::Constants& constants) {
    Slam slam(TestParameters(), {}, constants);
    return slam.Process(ScanRoom(TruePose(0), 1000, 180)).scan.rays.size();
  };
  CHECK(NumRays({}) == 180);
  CHECK(NumRays({.selection = {.valid_rays = {.usable_share = 0.1}}}) < 90);  // 2 m in a room of 7 x 5 m
}

TEST_CASE("what loops have brought is told once, one keyframe before it is taken up, also to a session that goes on") {
  Parameters parameters;
  parameters.scan.range_max_m = 50.0;
  Slam slam(parameters);
  Slam next_session(parameters);
  Simulator simulator(LoadWorld("block"), 1);
  int num_updates = 0;
  while (const auto scan = simulator.Next()) {
    const Slam::Step step = slam.Process(*scan);
    next_session.Restore(step.drawn ? &step.scan : nullptr, step.match);
    for (const GraphUpdate& update : step.updates) {
      CHECK(slam.graph().CountAfter(update.keyframe) == slam.mapper().lag() - 1);
      CHECK(next_session.Restore(update));
      ++num_updates;
    }
  }
  CHECK(num_updates > 0);
  CHECK(next_session.AwaitLoops() == slam.AwaitLoops());
  CHECK(next_session.AwaitLoops().empty());
  CHECK(next_session.graph().poses() == slam.graph().poses());
  CHECK((next_session.map().ToDenseGrid().cells == slam.map().ToDenseGrid().cells));
}

TEST_CASE("a scan that sees nothing is lost, draws nothing, and the next one is matched; as the first it is no map") {
  const LaserScan blind{5000, -1.0f, 0.5f, {0.0f, 0.0f, 0.0f}};
  Slam slam(TestParameters());
  Drive(slam, 5);
  CHECK(slam.Process(blind).match.state == MatchState::kLost);
  const ScanMatch match = slam.Process(ScanRoom(TruePose(5), 6000, 180)).match;
  CHECK(match.state == MatchState::kOk);
  CHECK(match.map_version == 6);
  CheckPose(match.T_map_laser, TruePose(5), 0.05);
  Slam blind_first(TestParameters());
  CHECK_FALSE(blind_first.Restore(nullptr, {5, {}, 0.0, 0, 0, 0, MatchState::kFirst}));
  CHECK(blind_first.tracking().num_scans() == 1);
  CHECK(blind_first.map_version() == 1);
  CHECK(blind_first.Process(blind).match.T_map_laser == Pose2{});
  CHECK(blind_first.map().empty());
  Drive(blind_first, 3);
  CHECK_FALSE(blind_first.map().empty());
}

TEST_CASE("a drive that goes on in a later session gives the poses and the map of one without a break") {
  Parameters parameters = TestParameters();
  parameters.update.update_distance_m = 0.1;  // some scans are drawn: those alone are kept
  parameters.update.update_angle_rad = 1.0;
  Slam whole(parameters);
  const std::vector<Slam::Step> steps = DriveSteps(whole);
  for (const std::size_t cut : {0, 1, 12, 25}) {
    CAPTURE(cut);
    Slam later(parameters);
    int num_drawn = 0;
    for (std::size_t k = 0; k < cut; ++k) {
      CHECK(later.Restore(steps[k].drawn ? &steps[k].scan : nullptr, steps[k].match) == steps[k].drawn);
      num_drawn += steps[k].drawn;
    }
    if (cut == 12) CHECK((num_drawn > 1 && num_drawn < 12));
    for (std::size_t k = cut; k < 25; ++k) {
      const auto i = static_cast<int>(k);
      CHECK(later.Process(ScanRoom(TruePose(i), 1000 + 100 * i, 180)).match == steps[k].match);
    }
    later.AwaitLoops();
    CHECK(later.tracking() == whole.tracking());
    CHECK(later.map().ToDenseGrid().cells == whole.map().ToDenseGrid().cells);
  }
}

TEST_CASE("on a finished map a drive is followed from wherever it begins, and the map stays as it is") {
  Parameters parameters;
  parameters.update.cell_size_m = 0.05;
  Slam slam(parameters);
  for (int k = 0; k < 40; ++k) slam.Process(ScanNiche(TruePose(k), 1000 + 100 * k));
  const DenseGrid before = slam.map().ToDenseGrid();
  slam.FinishMap();
  CHECK(slam.tracking().empty());
  for (int k = 0; k < 20; ++k) {
    const Pose2 truth{-1.5 + 0.05 * k, 1.5 - 0.02 * k, 2.0 + 0.03 * k};
    const ScanMatch match = slam.Process(ScanNiche(truth, 500 + k)).match;  // utimes of the first drive do not matter
    CAPTURE(k);
    CHECK(match.state == MatchState::kOk);
    CHECK(match.map_version == k);
    CheckPose(match.T_map_laser, truth, 0.05);
  }
  CHECK(slam.tracking().num_scans() == 20);
  CHECK(slam.map().ToDenseGrid().cells == before.cells);
}

}  // namespace crsm
