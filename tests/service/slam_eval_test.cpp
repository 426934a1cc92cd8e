#include <sys/wait.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "catch.hpp"
#include "common/worlds/world.hpp"

namespace fs = std::filesystem;

namespace {

struct Output {
  int exit_code = 0;
  std::string text;
};

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Runs slam_eval in the shell; `arguments` may redirect.
Output RunEval(const std::string& arguments) {
  FILE* pipe = popen((CRSM_BIN_DIR "/slam_eval " + arguments).c_str(), "r");
  REQUIRE(pipe);
  Output output;
  std::array<char, 4096> buffer;
  while (const std::size_t count = fread(buffer.data(), 1, buffer.size(), pipe))
    output.text.append(buffer.data(), count);
  output.exit_code = WEXITSTATUS(pclose(pipe));
  return output;
}

/// A folder with a trajectory that turns left by 90 degrees, and a relation that it misses by 5 cm and no angle.
struct Fixture {
  const fs::path folder = MakeFolder();
  const std::string trajectory = folder / "trajectory.tum";
  const std::string relations = folder / "known.relations";

  Fixture() {
    std::ofstream(trajectory) << "1.000000 0 0 0 0 0 0 1\n2.000000 2 0 0 0 0 0.707106781 0.707106781\n";
    std::ofstream(relations) << "1 2 2.03 0.04 0 0 0 1.570796327\n1 9 0 0 0 0 0 0\n";
  }
  ~Fixture() { fs::remove_all(folder); }

  static fs::path MakeFolder() {
    std::string name = fs::temp_directory_path() / "crsm_slam_eval_test_XXXXXX";
    REQUIRE(mkdtemp(name.data()));
    return name;
  }
};

}  // namespace

TEST_CASE("slam_eval relations prints a table, from the file or from the folder that holds it") {
  const Fixture fixture;
  const Output file = RunEval("relations " + fixture.trajectory + " " + fixture.relations);
  CHECK(file.exit_code == 0);
  CHECK(file.text ==
        "relations used 1, missing 1\n"
        "error                  mean       std    median       max\n"
        "translation [m]      0.0500    0.0000    0.0500    0.0500\n"
        "rotation [rad]       0.0000    0.0000    0.0000    0.0000\n"
        "rotation [deg]       0.0000    0.0000    0.0000    0.0000\n");
  CHECK(RunEval("relations " + fixture.folder.string() + " " + fixture.relations).text == file.text);
}

TEST_CASE("slam_eval relations shifts the laser's poses to the robot's centre and prints JSON") {
  const Fixture fixture;
  // A laser 0.1 m behind the centre: the robot goes from (0.1, 0) to (2, 0.1), so from its start by (1.9, 0.1).
  const Output output =
      RunEval("relations " + fixture.trajectory + " " + fixture.relations + " --laser-x-m -0.1 --json");
  CHECK(output.exit_code == 0);
  const auto json = nlohmann::json::parse(output.text);
  CHECK(json["relations_used"] == 1);
  CHECK(json["relations_missing"] == 1);
  const double expected_m = std::hypot(2.03 - 1.9, 0.04 - 0.1);
  for (const char* name : {"mean", "median", "max"}) {
    CHECK(json["translation_m"][name].get<double>() == Approx(expected_m).margin(1e-6));  // the file's decimals
    CHECK(json["rotation_rad"][name].get<double>() == Approx(0.0).margin(1e-6));
  }
  CHECK(json["translation_m"]["std"] == 0.0);
}

TEST_CASE("slam_eval world prints the text of a world, which is a world again, and draws it") {
  const Fixture fixture;
  const Output text = RunEval("world env2");
  CHECK(text.exit_code == 0);
  CHECK(text.text == crsm::LoadWorldText("env2"));
  const std::string file = fixture.folder / "edited.world";
  std::ofstream(file) << text.text << "person 11 3 11 9 0.5\n";
  const std::string picture = fixture.folder / "world.png";
  CHECK(RunEval("world " + file + " --out " + picture).exit_code == 0);
  CHECK(ReadFile(picture).substr(1, 3) == "PNG");
}

TEST_CASE("slam_eval map and trajectory measure what slam_offline leaves of a simulated world") {
  const Fixture fixture;
  const std::string world = fixture.folder / "room.world";
  std::ofstream(world) << "box 0 0 5 4\nbox 2 2.4 0.8 0.7\nbox 3.4 0 0.5 0.6\nlaser 270 270 9.5 5 0.01\nspeed 0.3 0.5\n"
                          "waypoint 1 1.4\nwaypoint 2.4 1.4\ncorner box 2 2.4\ncorner room 5 4\n";
  const std::string out = fixture.folder / "out";
  const std::string offline = CRSM_BIN_DIR "/slam_offline sim:" + world + " --preset paper --out " + out;
  REQUIRE(std::system((offline + " >/dev/null 2>&1").c_str()) == 0);

  const auto map = nlohmann::json::parse(RunEval("map " + out + " " + world + " --json").text);
  CHECK(map["omse_px2"] < 2.0);  // a wall's cells are off by one or so: the noise is half a cell
  CHECK(map["cmse_px2"] < 3.5);
  CHECK(map["obstacles"] > 100);
  CHECK(map["corners"].size() == 2);
  CHECK(map["corners"][0]["name"] == "box");
  CHECK(map["mean_fitness"] == nlohmann::json::parse(ReadFile(out + "/summary.json"))["mean_fitness"]);
  CHECK(RunEval("map " + out + " " + world).text.rfind("OMSE ", 0) == 0);

  const auto trajectory = nlohmann::json::parse(RunEval("trajectory " + out + " --json").text);
  CHECK(trajectory["poses"] > 20);
  CHECK(trajectory["mean_m"] < 0.04);
  CHECK(RunEval("trajectory " + out + "/truth.tum").text.find("mean 0.0000") != std::string::npos);
  CHECK(RunEval("trajectory " + out + "/trajectory.tum " + out + "/truth.tum --json").text ==
        RunEval("trajectory " + out + " --json").text);

  // A corner where nothing is: the map is not given a figure.
  std::ofstream(world, std::ios::app) << "box 20 20 1 1\ncorner nowhere 20 20\n";
  const Output missing = RunEval("map " + out + " " + world + " 2>&1");
  CHECK(missing.exit_code == 1);
  CHECK(missing.text.find("1 of the 3 corners of " + world + " are not in the map of " + out + ": nowhere") !=
        std::string::npos);
}

TEST_CASE("slam_eval summary prints a line for each run, and names the folders that have none") {
  const Fixture fixture;
  const auto write = [&](const std::string& name, const std::string& json) {
    fs::create_directories(fixture.folder / name);
    std::ofstream(fixture.folder / name / "summary.json") << json;
  };
  write("a", R"({"scans": 4934, "lost": 2, "mean_fitness": 0.91349, "verdict": {"trust": "good"},
                 "loops": {"closed": 12}, "wall_s": 3.14159})");
  write("long, name", R"({"scans": 5, "lost": 0, "mean_fitness": 0.5, "verdict": {"trust": "doubtful"}})");
  write("bad", R"({"scans": 5})");
  const std::string in = "cd " + fixture.folder.string() + " && " CRSM_BIN_DIR "/slam_eval summary ";
  const auto run = [&](const std::string& arguments) {  // from within the folder, whose name is another each time
    const std::string to = fixture.folder / "output";
    const int status = std::system((in + arguments + " >" + to + " 2>" + to + ".err").c_str());
    return Output{WEXITSTATUS(status), ReadFile(to)};
  };
  const Output table = run("a 'long, name'");
  CHECK(table.exit_code == 0);
  CHECK(table.text ==
        "run         verdict   scans  lost  loops  fitness  wall_s\n"
        "a           good       4934     2     12    0.913     3.1\n"
        "long, name  doubtful      5     0      -    0.500       -\n");
  CHECK(run("--csv 'long, name' a").text ==
        "run,verdict,scans,lost,loops,fitness,wall_s\n"
        "\"long, name\",doubtful,5,0,-,0.500,-\n"
        "a,good,4934,2,12,0.913,3.1\n");
  const Output with_bad = run("bad a nowhere");
  CHECK(with_bad.exit_code == 1);
  CHECK(with_bad.text == run("a").text);
  CHECK(ReadFile(fixture.folder / "output.err").empty());  // of the last one
  run("bad a nowhere");
  CHECK(ReadFile(fixture.folder / "output.err") ==
        "slam_eval: 2 of 3 runs have no summary: bad/summary.json: must have the numbers scans, lost and mean_fitness, "
        "and a verdict; cannot read nowhere/summary.json\n");
}

TEST_CASE("slam_eval says what is wrong in one line, and exits 2 where the flags are") {
  const Fixture fixture;
  const std::string bad = fixture.folder / "bad.relations";
  std::ofstream(bad) << "1 2 3\n";
  const auto Check = [](const std::string& arguments, const std::string& expected, int exit_code = 1) {
    INFO(arguments);
    const Output output = RunEval(arguments + " 2>&1 >/dev/null");
    CHECK(output.exit_code == exit_code);
    CHECK(output.text.find(expected) != std::string::npos);
    CHECK(output.text.rfind("slam_eval: ", 0) == 0);
    CHECK(output.text.find('\n') == output.text.size() - 1);
  };
  Check("", "subcommand", 2);
  Check("nonsense", "subcommand", 2);
  Check("relations " + fixture.trajectory, "RELATIONS", 2);
  Check("world nowhere", "there is no world file nowhere");
  Check("world env1 --out /no/such/folder/w.png", "cannot write /no/such/folder/w.png");
  Check("world env1 --cell-size-m nan --out /dev/null", "--cell-size-m", 2);
  Check("trajectory " + fixture.trajectory, "truth.tum");
  Check("map " + fixture.folder.string() + " env1", "map.yaml");
  std::ofstream(fixture.folder / "map.yaml") << "resolution: 0.05\n";
  Check("map " + fixture.folder.string() + " env1", "map.yaml: must have lines");
  std::ofstream(fixture.folder / "map.yaml") << "resolution: 0.05\norigin: [0, 0, 0]\n";
  Check("map " + fixture.folder.string() + " env1", "map.png: cannot be read");
  Check("relations /no/such.tum " + fixture.relations, "/no/such.tum");
  Check("relations " + fixture.trajectory + " /no/such.relations", "/no/such.relations");
  Check("relations " + fixture.trajectory + " " + bad, "bad.relations:1: must be the eight numbers");
  const std::string empty = fixture.folder / "empty.relations";
  std::ofstream(empty).flush();
  Check("relations " + fixture.trajectory + " " + empty, "none of the 0 relations");
  Check("relations " + fixture.trajectory + " " + fixture.relations + " --laser-x-m nan", "--laser-x-m", 2);
  Check("relations " + fixture.trajectory + " " + fixture.relations + " --laser-x-m 11", "within -10 and 10", 2);
  Check("relations " + fixture.trajectory + " " + fixture.relations + " --laser-x-m near", "--laser-x-m", 2);
}

TEST_CASE("slam_eval tells its help and version") {
  const Output help = RunEval("--help");
  CHECK(help.exit_code == 0);
  CHECK(help.text.find("relations") != std::string::npos);
  CHECK(RunEval("relations --help").exit_code == 0);
  const Output version = RunEval("--version");
  CHECK(version.exit_code == 0);
  CHECK(version.text.rfind("slam_eval ", 0) == 0);
}
