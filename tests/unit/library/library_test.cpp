#include <algorithm>
#include <cmath>
#include <crsm_slam/slam.hpp>
#include <limits>
#include <map>
#include <span>

#include "catch.hpp"
#include "common/set_parameter.hpp"
#include "common/slam.hpp"
#include "common/worlds/simulator.hpp"
#include "parameters_of.hpp"
#include "scratch.hpp"
#include "services/library/presets.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

crsm_slam::Scan ToPublic(const LaserScan& scan) {
  return {scan.utime, scan.angle_min_rad, scan.angle_step_rad, scan.ranges_m};
}

void CheckSame(const crsm_slam::Pose& a, const Pose2& b) { CHECK(Pose2{a.x_m, a.y_m, a.yaw_rad} == b); }

void CheckSame(const crsm_slam::Map& map, const DenseGrid& grid) {
  CHECK(map.width_cells == grid.width_cells);
  CHECK(map.height_cells == grid.height_cells);
  CHECK(map.cell_size_m == grid.cell_size_m);
  CHECK(map.T_map_grid.x_m == grid.origin_x_cells * grid.cell_size_m);
  CHECK(map.T_map_grid.y_m == grid.origin_y_cells * grid.cell_size_m);
  CHECK(map.cells == grid.cells);
}

}  // namespace

TEST_CASE("the library's map, poses and loops are those of the algorithm, whoever looks at them in between") {
  const bool with_loops = GENERATE(true, false);
  CAPTURE(with_loops);
  const std::vector<LaserScan> scans =
      ScansOf(LoadWorld("block"), 1, with_loops ? 1600 : 300);  // round a block, and back
  Slam slam(ParametersOf({"--preset", "sick", with_loops ? "--loops" : "--no-loops"}));
  crsm_slam::Slam library({.preset = "sick", .values = {{"loops", with_loops ? "true" : "false"}}});
  std::vector<ScanMatch> matches;
  bool loop_closed = false;
  for (const LaserScan& scan : scans) {
    const Slam::Step wanted = slam.Process(scan);
    const crsm_slam::Step step = library.Process(ToPublic(scan));
    CheckSame(step.T_map_laser, wanted.match.T_map_laser);
    REQUIRE(static_cast<int>(step.state) == static_cast<int>(wanted.match.state));
    REQUIRE(step.fitness == wanted.match.fitness);
    REQUIRE(step.covariance == wanted.match.covariance);
    REQUIRE(step.degenerate_axis == wanted.match.degenerate_axis);
    REQUIRE(step.drawn == wanted.drawn);
    loop_closed |= step.loop_closed;
    matches.push_back(wanted.match);
    if (matches.size() % 500 == 0) library.MakeMap();
  }
  CHECK(loop_closed == with_loops);

  if (!with_loops) CheckSame(library.MakeMap(), slam.map().ToDenseGrid());
  const Slam::Outcome outcome = slam.Finalize(matches);
  if (with_loops) CheckSame(library.MakeMap(), outcome.map.ToDenseGrid());
  const auto trajectory = library.Trajectory();
  REQUIRE(trajectory.size() == matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    CHECK(trajectory[i].utime == matches[i].utime);
    CheckSame(trajectory[i].T_map_laser, matches[i].T_map_laser);
  }
  const auto loops = library.Loops();
  REQUIRE(loops.size() == outcome.graph.loops().size());
  CHECK(loops.empty() != with_loops);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const Loop& loop = outcome.graph.loops()[i];
    CHECK(loops[i].older_utime == outcome.graph.keyframe(loop.older).utime);
    CHECK(loops[i].newer_utime == outcome.graph.keyframe(loop.newer).utime);
    CheckSame(loops[i].T_older_newer, loop.T_older_newer);
  }
}

TEST_CASE("the library knows of a loop as soon as it is asked, and says with the next scan that there is one") {
  const std::vector<LaserScan> scans = ScansOf(LoadWorld("block"), 1, 1600);
  Slam slam(ParametersOf({"--preset", "sick"}));
  crsm_slam::Slam library({.preset = "sick"});
  std::size_t next = 0;
  do {
    REQUIRE(next + 1 < scans.size());
    slam.Process(scans[next]);
    CHECK_FALSE(library.Process(ToPublic(scans[next++])).loop_closed);
  } while (std::ranges::none_of(slam.AwaitLoops(), &crsm::GraphUpdate::ChangesGraph));
  CHECK_FALSE(library.Loops().empty());
  CHECK(library.Process(ToPublic(scans[next])).loop_closed);
}

TEST_CASE("the library says which scans are on its map, and on which piece the others are") {
  std::vector<LaserScan> scans = ScansOf(LoadWorld("block"), 1, 700);
  scans.erase(scans.begin() + 300, scans.begin() + 600);
  for (std::size_t i = 300; i < scans.size(); ++i) scans[i].utime += 60'000'000;  // a minute later, elsewhere
  crsm_slam::Slam library({.preset = "sick"});
  std::vector<crsm_slam::Step> steps;
  for (const LaserScan& scan : scans) steps.push_back(library.Process(ToPublic(scan)));
  const auto trajectory = library.Trajectory();
  REQUIRE(trajectory.size() == 400);
  for (std::size_t i = 0; i < 400; ++i) {
    CAPTURE(i);
    CHECK(steps[i].on_map == (i < 300));
    CHECK(trajectory[i].piece == (i < 300 ? 1 : 2));
    CHECK(trajectory[i].state == steps[i].state);
  }
  CHECK(trajectory[300].state == crsm_slam::State::kFirst);
}

TEST_CASE("the library's presets and profiles are those of the programs") {
  // The programs read the files by a TOML parser, the library's values are cut from them when it is built.
  const auto Compare = [](const std::string& flag, std::span<const crsm_slam::PresetValue> values) {
    std::map<std::string, Parameters> by_name;
    for (const crsm_slam::PresetValue& value : values) {
      ValueSetter setter(std::string(value.key), {WrittenValue::Kind::kFlag, std::string(value.text)});
      VisitParameters(by_name[std::string(value.name)], setter);
      CHECK(setter.found());
    }
    for (const auto& [name, parameters] : by_name) {
      CAPTURE(name);
      CHECK(ListParameters(parameters) == ListParameters(ParametersOf({flag.c_str(), name.c_str()})));
    }
  };
  Compare("--preset", crsm_slam::kPresetValues);
  Compare("--profile", crsm_slam::kProfileValues);
  CHECK(crsm_slam::Presets() == std::vector<std::string>{"paper", "rplidar-a1", "sick", "urg-04lx", "utm-30lx"});
}

TEST_CASE("the library uses the preset, the profile and the values that it is told, the later before the earlier") {
  const std::vector<LaserScan> scans = ScansOf(LoadWorld("demo"), 1, 3);
  const auto CellSize = [&](const crsm_slam::Settings& settings) {
    crsm_slam::Slam library(settings);
    for (const LaserScan& scan : scans) library.Process(ToPublic(scan));
    return library.MakeMap().cell_size_m;
  };
  CHECK(CellSize({}) == 0.05);
  CHECK(CellSize({.preset = "urg-04lx"}) == 0.03);
  CHECK(CellSize({.preset = "urg-04lx", .profile = "paper"}) == 0.03);
  CHECK(CellSize({.preset = "urg-04lx", .values = {{"cell_size_m", "0.1"}}}) == 0.1);
}

TEST_CASE("a setting of the library that is none is refused in one line that says what would be right") {
  const std::vector<std::pair<crsm_slam::Settings, const char*>> refused{
      {crsm_slam::Settings{.preset = "sikc"},
       "preset: 'sikc' is not one of paper, rplidar-a1, sick, urg-04lx, utm-30lx; did you mean sick?"},
      {crsm_slam::Settings{.profile = "best"}, "profile: 'best' is not one of default, paper"},
      {crsm_slam::Settings{.values = {{"range_max", "4"}}}, "range_max: no such key; "},
      {crsm_slam::Settings{.values = {{"cell_size_m", "5"}}}, "cell_size_m: '5' is not a number from 0.005 to 1"},
      {crsm_slam::Settings{.values = {{"loops", "yes"}}}, "loops: 'yes' is not true or false"}};
  for (const auto& [settings, error] : refused) {
    CHECK(ErrorOf([&, &these = settings] { crsm_slam::Slam slam(these); }).starts_with(error));
  }
  CHECK_NOTHROW(crsm_slam::Slam({.profile = "default"}));
}

TEST_CASE("the library refuses what is no scan, and goes on as if it had not been there") {
  const std::vector<LaserScan> scans = ScansOf(LoadWorld("demo"), 1, 20);
  crsm_slam::Slam library;
  crsm_slam::Slam undisturbed;
  CHECK(library.MakeMap().cells.empty());
  CHECK(library.Trajectory().empty());
  CHECK(library.Loops().empty());
  const crsm_slam::Scan good = ToPublic(scans[0]);
  const auto Refused = [&](auto&& spoil) {
    crsm_slam::Scan scan = good;
    scan.utime = 1;
    spoil(scan);
    CHECK_THROWS_AS(library.Process(scan), std::invalid_argument);
  };
  for (const LaserScan& scan : scans) {
    library.Process(ToPublic(scan));
    undisturbed.Process(ToPublic(scan));
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    Refused([](auto& bad) { bad.utime = -1; });
    Refused([&](auto& bad) { bad.utime = good.utime; });  // it was there before
    Refused([](auto& bad) { bad.ranges_m.resize(1); });
    Refused([](auto& bad) { bad.ranges_m.resize(4097); });
    Refused([](auto& bad) { bad.angle_min_rad = kNan; });
    Refused([](auto& bad) { bad.angle_min_rad = 6.3f; });
    Refused([](auto& bad) { bad.angle_step_rad = 0.0f; });
    Refused([](auto& bad) { bad.angle_step_rad = kNan; });
    Refused([](auto& bad) { bad.angle_step_rad = 1.0f; });
    crsm_slam::Scan later = good;
    later.utime = 2;
    CHECK_THROWS_AS(library.Process(later, crsm_slam::Pose{0.0, kNan, 0.0}), std::invalid_argument);
    CHECK_THROWS_AS(library.Process(later, crsm_slam::Pose{2e6, 0.0, 0.0}), std::invalid_argument);
  }
  CHECK(library.Trajectory().size() == scans.size());
  CHECK(library.MakeMap().cells == undisturbed.MakeMap().cells);
}

TEST_CASE("a scan of the library may have ranges that are none, and no range at all") {
  crsm_slam::Slam library;
  for (const LaserScan& scan : ScansOf(LoadWorld("demo"), 1, 10)) {
    crsm_slam::Scan spoilt = ToPublic(scan);
    spoilt.ranges_m[3] = std::numeric_limits<float>::quiet_NaN();
    spoilt.ranges_m[4] = std::numeric_limits<float>::infinity();
    spoilt.ranges_m[5] = -1.0f;
    library.Process(spoilt);
  }
  const std::vector<std::uint8_t> before = library.MakeMap().cells;
  crsm_slam::Scan blind{.utime = 1, .angle_step_rad = 0.1f, .ranges_m = std::vector<float>(20)};
  CHECK(library.Process(blind).state == crsm_slam::State::kLost);
  CHECK(library.MakeMap().cells == before);
}

TEST_CASE("the library uses the odometry that it is handed") {
  Slam with{Parameters()};
  Slam without{Parameters()};
  crsm_slam::Slam library;
  crsm_slam::Slam library_without;
  bool odometry_tells = false;
  Simulator simulator(LoadWorld("demo"), 1);
  for (int k = 0; k < 900; ++k) {
    const auto scan = simulator.Next();
    REQUIRE(scan);
    if (k % 15 != 0) continue;  // so few scans that odometry tells more than the last motions
    const Pose2 T_odom_robot = *RoundOdometry(*simulator.TruePose());
    const crsm_slam::Pose wheels{T_odom_robot.x_m, T_odom_robot.y_m, T_odom_robot.yaw_rad};
    const Pose2 wanted = with.Process(*scan, T_odom_robot).match.T_map_laser;
    const Pose2 wanted_without = without.Process(*scan).match.T_map_laser;
    CheckSame(library.Process(ToPublic(*scan), wheels).T_map_laser, wanted);
    CheckSame(library_without.Process(ToPublic(*scan)).T_map_laser, wanted_without);
    odometry_tells |= !(wanted == wanted_without);
  }
  CHECK(odometry_tells);
}

}  // namespace crsm
