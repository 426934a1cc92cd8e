// Sweeps that are deskewed: the matcher finds by what, all others are told.

#include "catch.hpp"
#include "processes.hpp"

namespace crsm {

TEST_CASE("run_stack deskews sweeps as slam_offline does") {
  const TemporaryFolder folder;
  const std::vector<std::string> map{"sim:arena", "--preset", "rplidar-a1", "--out"};
  const auto With = [&](std::vector<std::string> more) {
    more.insert(more.begin(), map.begin(), map.end());
    return more;
  };
  REQUIRE(Run("slam_offline", With({folder / "offline"}), folder / "log") == 0);
  REQUIRE(Run("slam_offline", With({folder / "skewed", "--sweep-s", "0"}), folder / "log") == 0);
  REQUIRE(Run(CRSM_SOURCE_DIR "/scripts/run_stack", With({folder / "out", "--lcm-url", MakeBusUrl()}),
              folder / "log") == 0);
  for (const std::string file : {"map.png", "trajectory.tum", "overview.png", "graph.g2o"}) {
    INFO(file);
    const std::string content = ReadFile(folder / "offline" / file);
    CHECK_FALSE(content.empty());
    CHECK(ReadFile(folder / "out" / file) == content);
    CHECK(ReadFile(folder / "skewed" / file) != content);
  }
}

TEST_CASE("a run whose sweeps are deskewed goes on from its journal") {
  const TemporaryFolder folder;
  const std::vector<std::string> flags{"sim:arena", "--preset", "rplidar-a1", "--out", folder / "out"};
  REQUIRE(Run("slam_offline", flags, folder / "log") == 0);
  const std::string trajectory = ReadFile(folder / "out/trajectory.tum");
  const std::string map = ReadFile(folder / "out/map.png");
  const std::vector<std::string> again{"sim:arena", "--out", folder / "out", "--resume", folder / "out"};
  REQUIRE(Run("slam_offline", again, folder / "log") == 0);  // all of it is there already
  CHECK(ReadFile(folder / "out/trajectory.tum") == trajectory);
  CHECK(ReadFile(folder / "out/map.png") == map);
}

}  // namespace crsm
