// Another loop closer in the place of ours, with nothing else changed.

#include <vector>

#include "catch.hpp"
#include "common/logs/read_map.hpp"
#include "common/results/results.hpp"
#include "common/slam.hpp"
#include "parameters_of.hpp"
#include "processes.hpp"
#include "tests/matchers/nearby_loop_closer.hpp"

using namespace crsm;

TEST_CASE("a stack with another loop closer closes loops, and gives the bytes that the loop in one process gives") {
  const std::vector<std::string> flags{"--preset", "sick"};
  const TemporaryFolder folder;
  const std::vector<LaserScan> scans = TakeScans("sim:block", 1600);  // round the block and somewhat further
  const std::string log = folder.Write(scans, "drive.lcm");
  Stack stack({MakeBusUrl(), folder / "out", flags});
  for (const char* service : {"map_updater", "nearby_loop_closer", "rrhc_matcher", "ray_selector", "map_exporter"}) {
    INFO(service);
    REQUIRE(stack.Start(service));
  }
  REQUIRE(stack.StartPublisher(log, "max"));
  CHECK(stack.Finish());

  Slam slam(ParametersOf(flags), {.make_loop_closer = [] { return std::make_unique<NearbyLoopCloser>(); }});
  std::vector<ScanMatch> matches;
  for (const LaserScan& scan : scans) matches.push_back(slam.Process(scan).match);
  const Slam::Outcome outcome = slam.Finalize(matches);
  Trajectory expected;
  for (const ScanMatch& match : matches) expected.push_back({match.utime, match.T_map_laser});
  CHECK_FALSE(outcome.graph.loops().empty());
  CHECK((ReadFile(folder / "out/trajectory.tum") == FormatTrajectory(expected)));
  CHECK((ReadMap(folder / "out").cells == outcome.map.ToDenseGrid().cells));
}
