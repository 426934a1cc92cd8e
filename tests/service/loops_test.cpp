// Loops: what slam_offline --loops leaves, how such a map goes on, and who refuses it.

#include <fstream>

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kAsMeasured{"--preset", "sick", "--angle-scale", "1"};

struct Ended {
  int exit_code = 0;
  std::string output;
  std::string errors;
};

Ended RunProgram(const TemporaryFolder& folder, const std::string& program, std::vector<std::string> arguments) {
  Process process(program, arguments, folder / "log");
  const int exit_code = process.AwaitExit();
  return {exit_code, process.output(), process.errors()};
}

Ended MapOffline(const TemporaryFolder& folder, const std::string& log, const std::string& out,
                 std::vector<std::string> flags = {"--loops"}) {
  flags.insert(flags.begin(), {log, "--out", folder / out});
  flags.insert(flags.end(), kAsMeasured.begin(), kAsMeasured.end());
  return RunProgram(folder, "slam_offline", flags);
}

/// Round the block and somewhat further, so that loops are closed.
struct Course {
  TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeScans("sim:block", 1600);

  std::string WriteFirst(std::size_t count) const {
    const fs::path path = folder / ("first_" + std::to_string(count) + ".lcm");
    WriteScans({scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(std::min(count, scans.size()))}, path);
    return path.string();
  }
};

nlohmann::json ReadSummary(const fs::path& out) { return nlohmann::json::parse(ReadFile(out / "summary.json")); }

}  // namespace

TEST_CASE("a run with loops that is cut short and resumed ends with the files of one in one go") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string log = course.WriteFirst(1600);
  const Ended whole = MapOffline(folder, log, "whole");
  REQUIRE(whole.exit_code == 0);
  const auto loops = ReadSummary(folder / "whole")["loops"];
  CHECK(loops["closed"] >= 2);
  CHECK(loops["keyframes"] > 300);
  CHECK(loops["taken_out"] == 0);
  CHECK(whole.output.find(std::to_string(loops["closed"].get<int>()) + " loops closed between ") != std::string::npos);
  CHECK(ReadFile(folder / "whole/graph.g2o").find("VERTEX_SE2 0 0.000000") == 0);

  // Before any loop, and at a place where one has been found and may not have taken effect yet.
  for (const std::size_t cut : {500, 1330, 1340, 1350}) {
    CAPTURE(cut);
    const std::string out = "cut_" + std::to_string(cut);
    REQUIRE(MapOffline(folder, course.WriteFirst(cut), out).exit_code == 0);
    CHECK(ReadFile(folder / out / "map.png") != ReadFile(folder / "whole/map.png"));
    const Ended resumed = MapOffline(folder, log, out, {"--resume", folder / out});  // --loops is the map's
    INFO(resumed.errors);
    REQUIRE(resumed.exit_code == 0);
    for (const char* file : {"map.png", "map.yaml", "trajectory.tum", "graph.g2o"}) {
      CAPTURE(file);
      CHECK_FALSE(ReadFile(folder / out / file).empty());
      CHECK(ReadFile(folder / out / file) == ReadFile(folder / "whole" / file));
    }
    CHECK(ReadSummary(folder / out)["loops"] == loops);
  }
}

TEST_CASE("what was mapped with loops is refused by the processes on a bus, in one line that says why") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string log = course.WriteFirst(30);
  REQUIRE(MapOffline(folder, log, "out").exit_code == 0);
  const auto journal = ReadFile(folder / "out/journal/journal.lcm");
  const std::string why = " was made with --loops: go on with slam_offline, which alone closes loops\n";

  const auto CheckRefused = [&](const std::string& program, std::vector<std::string> flags, const std::string& map) {
    INFO(program << " " << flags.front());
    flags.insert(flags.end(), {"--lcm-url", MakeBusUrl()});
    flags.insert(flags.end(), kAsMeasured.begin(), kAsMeasured.end());
    const Ended ended = RunProgram(folder, program, flags);
    CHECK(ended.exit_code == 2);
    CHECK(ended.errors == program + ": the map of " + map + why);
  };
  const std::string out = folder / "out";
  CheckRefused("map_updater", {"--journal", out + "/journal", "--resume"}, out + "/journal");
  CheckRefused("map_updater", {"--localize", out}, out + "/journal");
  CheckRefused("run_stack", {log, "--resume", out, "--out", out}, out);
  CheckRefused("run_stack", {log, "--resume", out, "--out", folder / "new"}, out);
  CheckRefused("run_stack", {log, "--localize", out, "--out", folder / "new"}, out);
  CHECK_FALSE(fs::exists(folder / "new"));
  CHECK(ReadFile(folder / "out/journal/journal.lcm") == journal);
}

TEST_CASE("a configuration with loops is refused by the processes on a bus before anything is begun") {
  const TemporaryFolder folder;
  const std::string config = folder / "loops.toml";
  std::ofstream(config) << "loops = true\n";
  const auto CheckRefused = [&](const std::string& program, std::vector<std::string> flags) {
    INFO(program << " " << flags.front());
    flags.insert(flags.end(), {"--config", config, "--lcm-url", MakeBusUrl()});
    const Ended ended = RunProgram(folder, program, flags);
    CHECK(ended.exit_code == 2);
    CHECK(ended.errors ==
          program + ": loops: slam_offline alone closes loops; leave this out of the configuration\n");
  };
  CheckRefused("map_updater", {"--journal", folder / "journal"});
  CheckRefused("run_stack", {"sim:block", "--out", folder / "out"});
  CHECK_FALSE(fs::exists(folder / "journal"));
  CHECK_FALSE(fs::exists(folder / "out"));
}

TEST_CASE("a robot is localised on a map that was made with loops, as it was put right") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  REQUIRE(MapOffline(folder, course.WriteFirst(1600), "map").exit_code == 0);
  const std::string log = folder / "again.lcm";
  WriteScans({course.scans.begin() + 1450, course.scans.begin() + 1500}, log);
  const Ended localised = MapOffline(folder, log, "localised", {"--localize", folder / "map"});
  INFO(localised.errors);
  REQUIRE(localised.exit_code == 0);
  CHECK(localised.output.find("50 scans, 0 lost") == 0);
  CHECK_FALSE(fs::exists(folder / "localised/graph.g2o"));
  CHECK_FALSE(ReadSummary(folder / "localised").contains("loops"));
}

TEST_CASE("without loops there is neither a graph nor a word of loops, and a map is not mixed of both") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string log = course.WriteFirst(30);
  const Ended plain = MapOffline(folder, log, "out", {});
  REQUIRE(plain.exit_code == 0);
  CHECK(plain.output.find("loops") == std::string::npos);
  CHECK_FALSE(fs::exists(folder / "out/graph.g2o"));
  CHECK_FALSE(ReadSummary(folder / "out").contains("loops"));

  const Ended mixed = MapOffline(folder, log, "out", {"--resume", folder / "out", "--loops"});
  CHECK(mixed.exit_code == 2);
  CHECK(mixed.errors.find("was made with false") != std::string::npos);

  // What an earlier run with loops left goes aside with the rest.
  REQUIRE(MapOffline(folder, log, "out", {"--loops", "--force"}).exit_code == 0);
  REQUIRE(fs::exists(folder / "out/graph.g2o"));
  REQUIRE(MapOffline(folder, log, "out", {"--force"}).exit_code == 0);
  CHECK_FALSE(fs::exists(folder / "out/graph.g2o"));
  CHECK(fs::exists(folder / "out/earlier.2/graph.g2o"));
}
