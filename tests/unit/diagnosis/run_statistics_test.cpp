#include "common/diagnosis/run_statistics.hpp"

#include <tuple>

#include "catch.hpp"
#include "diagnosis/wall_ahead.hpp"

namespace crsm {
namespace {

auto AllOf(const RunStatistics& statistics) {
  const RunStatistics::Values v = statistics.values();
  return std::tuple(v.counts.on_map, v.counts.lost, v.degenerate, v.counts.without_rays, v.longest_unmatched, v.steps,
                    v.far_steps, v.mean_fitness, v.finished_map, v.path_m, v.turns_by_odometry, v.ways_by_odometry);
}

/// The matches of a drive in which everything happens that is counted, ending in lost scans. far_m: by which all poses
/// are off.
void AddMatches(RunStatistics& statistics, double far_m, double fitness) {
  for (int i = 0; i < 100; ++i) {
    ScanMatch match;
    match.utime = i;
    match.state = i > 95 ? MatchState::kLost : i % 10 == 3 ? MatchState::kDegenerate : MatchState::kOk;
    match.T_map_laser = {far_m, 0.5 * (i % 2), 0.06 * (i % 2)};
    match.T_odom_robot = Pose2{0.0, 0.4 * (i % 2), 0.05 * (i % 2)};
    match.fitness = fitness;
    match.num_critical = i == 97 ? 0 : 70;
    match.map_version = 0;
    statistics.Add(match);
  }
}

}  // namespace

TEST_CASE("matches that are forgotten leave nothing behind, and come again to the rays that have stayed") {
  const ByteMap wall = MakeWall();
  RunStatistics statistics;
  for (int i = 0; i < 100; ++i) statistics.Add(i, LookAhead(2.05f));
  AddMatches(statistics, -1.0, 0.5);  // a metre from where they were: the wall is not there
  REQUIRE(statistics.ComputeMeanAgreement(wall) < 0.9);
  REQUIRE(statistics.values().turns_by_odometry);

  statistics.ForgetMatches();
  CHECK(AllOf(statistics) == AllOf(RunStatistics()));
  CHECK_FALSE(statistics.ComputeMeanAgreement(wall));

  RunStatistics fresh;
  AddMatches(fresh, 0.0, 0.75);
  AddMatches(statistics, 0.0, 0.75);
  CHECK(AllOf(statistics) == AllOf(fresh));
  CHECK_FALSE(fresh.ComputeMeanAgreement(wall));
  CHECK(statistics.ComputeMeanAgreement(wall) > 0.9);
}

TEST_CASE("the path goes on over lost scans, but neither to another piece nor to another trajectory") {
  RunStatistics statistics;
  auto Add = [&, utime = std::int64_t{0}](double x_m, MatchState state, int trajectory, bool floating) mutable {
    ScanMatch match;
    match.utime = utime += 100'000;
    match.T_map_laser = {x_m, 0.0, 0.0};
    match.state = state;
    match.fitness = floating ? 0.1 : 0.8;
    match.num_critical = 70;
    match.map_version = 1;
    match.trajectory = trajectory;
    match.floating = floating;
    statistics.Add(match);
  };
  for (int i = 0; i <= 10; ++i) Add(0.5 * i, MatchState::kOk, 0, false);
  Add(90.0, MatchState::kLost, 0, false);  // a guess
  Add(6.0, MatchState::kOk, 0, false);
  CHECK(statistics.values().path_m == Approx(6.0));
  for (int i = 0; i < 30; ++i) Add(50.0 + i, i == 0 ? MatchState::kFirst : MatchState::kOk, 1, true);
  CHECK(statistics.values().path_m == Approx(6.0));
  CHECK(statistics.values().longest_unmatched == 1);
  Add(20.0, MatchState::kFirst, 2, false);  // joined with the first one
  Add(21.0, MatchState::kOk, 2, false);
  const RunStatistics::Values values = statistics.values();
  CHECK(values.path_m == Approx(7.0));
  CHECK(values.furthest_m == Approx(6.0));
  CHECK(values.longest_jump_m == 0.0);
  CHECK(values.mean_fitness == Approx(0.8));
  CHECK(values.counts == ScanCounts{14, 30, 1, 0});
}

TEST_CASE("a step beyond the window of the search is far, and one that the noise may make adds nothing to the path") {
  struct Case {
    Pose2 step;
    std::int64_t num_far;
    double path_m;
  };
  for (const auto& [step, num_far, path_m] : {Case{{0.1, 0.0, 0.0}, 0, 0.0},
                                              {{0.3, 0.0, 0.0}, 0, 0.3},
                                              {{0.39, 0.0, 0.24}, 0, 0.39},
                                              {{0.0, 0.41, 0.0}, 1, 0.41},
                                              {{0.0, 0.0, -0.26}, 1, 0.0}}) {
    CAPTURE(step.x_m, step.y_m, step.yaw_rad);
    RunStatistics statistics;
    for (const auto& [utime, pose] : {std::pair(100'000, Pose2{}), std::pair(200'000, step)}) {
      ScanMatch match;
      match.utime = utime;
      match.T_map_laser = pose;
      match.state = MatchState::kOk;
      match.num_critical = 70;
      statistics.Add(match);
    }
    CHECK(statistics.values().far_steps == num_far);
    CHECK(statistics.values().path_m == Approx(path_m));
  }
}

TEST_CASE("the first match after all were forgotten is a step from nowhere") {
  RunStatistics statistics;
  AddMatches(statistics, 0.0, 0.5);
  ScanMatch match;
  match.utime = 200;
  match.state = MatchState::kOk;
  statistics.Add(match);
  statistics.ForgetMatches();
  statistics.Add(match);
  CHECK(statistics.values().steps == 0);
}

}  // namespace crsm
