// Another matcher in the place of rrhc_matcher, with nothing else changed.

#include <cmath>

#include "catch.hpp"
#include "common/logs/read_map.hpp"
#include "common/metrics/trajectory.hpp"
#include "common/results/results.hpp"
#include "common/slam.hpp"
#include "common/worlds/simulator.hpp"
#include "parameters_of.hpp"
#include "processes.hpp"
#include "tests/matchers/hill_climber.hpp"

using namespace crsm;

TEST_CASE("a stack with another matcher maps the drive, and gives the bytes that the loop in one process gives") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Stack stack({url, folder / "out", {"--preset", "urg-04lx"}});
  for (const char* service : {"map_updater", "loop_closer", "hill_climber", "ray_selector", "map_exporter"}) {
    INFO(service);
    REQUIRE(stack.Start(service));
  }
  REQUIRE(stack.StartPublisher("sim:corridor", "max"));
  CHECK(stack.Finish());

  Simulator simulator(LoadWorld("corridor"), ParametersOf({}).match.seed);
  Slam slam(ParametersOf({"--preset", "urg-04lx"}),
            {.make_matcher = [](double cell_size_m) { return std::make_unique<HillClimber>(cell_size_m); }});
  Trajectory expected;
  double worst_m = 0.0;
  while (const auto scan = simulator.Next()) {
    const Pose2 found = slam.Process(*scan).match.T_map_laser;
    expected.push_back({scan->utime, found});
    const Pose2 error = Inverse(*simulator.TruePose()) * found;
    worst_m = std::max(worst_m, std::hypot(error.x_m, error.y_m));
  }
  CHECK(ReadFile(folder / "out/trajectory.tum") == FormatTrajectory(expected));
  CHECK(ReadMap(folder / "out").cells == slam.map().ToDenseGrid().cells);
  CHECK(worst_m < 0.5);  // it maps, if less well than ours: 0.05 m would be a cell
}
