// Sweeps that are deskewed: the matcher finds by what, all others are told.

#include "catch.hpp"
#include "processes.hpp"

namespace crsm {

TEST_CASE("run_stack deskews sweeps as slam_offline does, and such a run goes on from its journal") {
  const TemporaryFolder folder;
  const std::vector<std::string> flags{"--preset", "rplidar-a1"};
  folder.Map("sim:arena", "offline", flags);
  folder.Map("sim:arena", "skewed", {"--preset", "rplidar-a1", "--sweep-s", "0"});
  folder.MapWithStack("sim:arena", "stack/offline", flags);  // overview.png shows the folder's name
  folder.CheckSame("stack/offline", "offline", {"map.png", "trajectory.tum", "overview.png", "graph.g2o"});
  for (const std::string file : {"map.png", "trajectory.tum"}) {
    CHECK((ReadFile(folder / "skewed" / file) != ReadFile(folder / "offline" / file)));
  }

  // It goes on from its journal: all of it is there already.
  folder.Map("sim:arena", "again", {"--resume", folder / "offline"});
  folder.CheckSame("again", "offline");
}

}  // namespace crsm
