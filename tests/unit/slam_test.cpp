#include "common/slam.hpp"

#include <cmath>

#include "catch.hpp"
#include "synthetic_scans.hpp"

namespace crsm {
namespace {

/// Where the laser is at the k-th scan: along a bend of 1 m, 4 cm and 1.1 degrees a scan.
Pose2 TruePose(int k) { return {2.0 * std::sin(0.02 * k), 2.0 * (1.0 - std::cos(0.02 * k)), 0.02 * k}; }

Parameters SlamParameters() {
  Parameters parameters = TestParameters();
  parameters.match.num_evaluations = 1000;
  parameters.update.join_hits = true;  // hits are two cells apart: alone they would dot the wall, not draw it
  return parameters;
}

std::vector<ScanMatch> Drive(Slam& slam, int num_scans = 25) {
  for (int k = 0; k < num_scans; ++k) slam.Process(ScanRoom(TruePose(k), 1000 + 100 * k, 180));
  return slam.history();
}

void CheckSamePose(const Pose2& a, const Pose2& b, double margin_m) {
  CHECK(a.x_m == Approx(b.x_m).margin(margin_m));
  CHECK(a.y_m == Approx(b.y_m).margin(margin_m));
  CHECK(a.yaw_rad == Approx(b.yaw_rad).margin(margin_m / 3.0));  // at the walls, 3 m away, it is as much
}

}  // namespace

TEST_CASE("a drive around a room is followed to within a cell, and its map is the room") {
  Slam slam(SlamParameters());
  const auto history = Drive(slam);
  REQUIRE(history.size() == 25);
  CHECK(history.front().state == MatchState::kFirst);
  for (int k = 0; k < 25; ++k) {
    CAPTURE(k);
    const ScanMatch& match = history[static_cast<std::size_t>(k)];
    CHECK(match.utime == 1000 + 100 * k);
    CHECK(match.map_version == k);
    CheckSamePose(match.T_map_laser, TruePose(k), 0.05);
  }
  const DenseGrid grid = slam.map().ToDenseGrid(0.05);
  CHECK(std::abs(grid.width_cells - 142) <= 2);  // the room's, and a cell at each wall
  CHECK(std::abs(grid.height_cells - 102) <= 2);
  CHECK(slam.map().At({0, 0}) > 200);
  CHECK(slam.geometry().cell_size_m() == 0.05);
}

TEST_CASE("the same seed draws the same map bit for bit, another seed the same drive within a cell") {
  Parameters parameters = SlamParameters();
  Slam first(parameters);
  Slam again(parameters);
  parameters.match.seed = 99;
  Slam other(parameters);
  const auto history = Drive(first);
  CHECK(Drive(again) == history);
  CHECK(again.map().ToDenseGrid(0.05).cells == first.map().ToDenseGrid(0.05).cells);
  const auto other_history = Drive(other);
  CHECK(other_history != history);
  CheckSamePose(other_history.back().T_map_laser, history.back().T_map_laser, 0.05);
}

TEST_CASE("the paper's way follows the drive to within two of its cells") {
  Parameters parameters = TestParameters();
  parameters.selection.density_scale_mode = DensityScaleMode::kPrevious;
  parameters.match.num_evaluations = 5000;
  parameters.match.climb = ClimbMode::kFixed;
  parameters.match.interpolate = false;
  parameters.match.velocity_model = false;
  parameters.match.final_climb = false;
  parameters.match.unexplored_score = -100.0;
  parameters.update.sparseness_intensity = true;
  Slam slam(parameters);
  CheckSamePose(Drive(slam).back().T_map_laser, TruePose(24), 0.1);
}

TEST_CASE("a scan that sees nothing is lost, and the next one is matched again") {
  Slam slam(SlamParameters());
  Drive(slam, 5);
  const LaserScan blind{5000, -1.0f, 0.5f, {0.0f, 0.0f, 0.0f}};
  CHECK(slam.Process(blind).state == MatchState::kLost);
  const ScanMatch match = slam.Process(ScanRoom(TruePose(5), 6000, 180));
  CHECK(match.state == MatchState::kOk);
  CHECK(match.map_version == 6);
  CheckSamePose(match.T_map_laser, TruePose(5), 0.05);
}

TEST_CASE("a first scan that sees nothing does not keep the next ones from making a map") {
  Slam slam(SlamParameters());
  CHECK(slam.Process({1, -1.0f, 0.5f, {0.0f, 0.0f}}).T_map_laser == Pose2{});
  CHECK(slam.map().tiles().entries().empty());
  Drive(slam, 3);
  CHECK_FALSE(slam.map().tiles().entries().empty());
}

TEST_CASE("a drive that goes on in a later session gives the poses and the map of one without a break") {
  Slam whole(SlamParameters());
  const auto history = Drive(whole);
  for (const int cut : {0, 1, 12, 25}) {
    CAPTURE(cut);
    Slam later(SlamParameters());
    for (int k = 0; k < cut; ++k) {
      const LaserScan scan = ScanRoom(TruePose(k), 1000 + 100 * k, 180);
      later.Restore(&scan, history[static_cast<std::size_t>(k)]);
    }
    for (int k = cut; k < 25; ++k) later.Process(ScanRoom(TruePose(k), 1000 + 100 * k, 180));
    CHECK(later.history() == history);
    CHECK(later.map().ToDenseGrid(0.05).cells == whole.map().ToDenseGrid(0.05).cells);
  }
}

TEST_CASE("a match whose scan is missing is restored and draws nothing") {
  Slam slam(SlamParameters());
  slam.Restore(nullptr, {5, {}, 0.0, 0, 0, 0, MatchState::kFirst});
  CHECK(slam.history().size() == 1);
  CHECK(slam.map().tiles().entries().empty());
}

TEST_CASE("on a finished map a drive is followed from wherever it begins, and the map stays as it is") {
  Parameters parameters;
  parameters.update.cell_size_m = 0.05;
  Slam slam(parameters);
  for (int k = 0; k < 40; ++k) slam.Process(ScanNiche(TruePose(k), 1000 + 100 * k));
  const DenseGrid before = slam.map().ToDenseGrid(0.05);
  slam.Freeze();
  CHECK(slam.history().empty());
  for (int k = 0; k < 20; ++k) {
    const Pose2 truth{-1.5 + 0.05 * k, 1.5 - 0.02 * k, 2.0 + 0.03 * k};
    const ScanMatch match = slam.Process(ScanNiche(truth, 500 + k));  // utimes of the first drive do not matter
    CAPTURE(k);
    CHECK(match.state == MatchState::kOk);
    CHECK(match.map_version == k);
    CheckSamePose(match.T_map_laser, truth, 0.05);
  }
  CHECK(slam.history().size() == 20);
  CHECK(slam.map().ToDenseGrid(0.05).cells == before.cells);
}

}  // namespace crsm
