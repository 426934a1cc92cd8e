#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "catch.hpp"
#include "common/worlds/world.hpp"
#include "processes.hpp"

using namespace crsm;

namespace fs = std::filesystem;

namespace {

/// A folder with a trajectory that turns left by 90 degrees, and a relation that it misses by 5 cm and no angle.
struct Fixture {
  TemporaryFolder folder;
  const std::string trajectory = folder / "trajectory.tum";
  const std::string relations = folder / "known.relations";

  Fixture() {
    std::ofstream(trajectory) << "1.000000 0 0 0 0 0 0 1\n2.000000 2 0 0 0 0 0.707106781 0.707106781\n";
    std::ofstream(relations) << "1 2 2.03 0.04 0 0 0 1.570796327\n1 9 0 0 0 0 0 0\n";
  }
  Ended Eval(const std::vector<std::string>& arguments) const { return folder.Run("slam_eval", arguments); }
  /// What is printed as JSON.
  nlohmann::json Json(std::vector<std::string> arguments) const {
    arguments.push_back("--json");
    const Ended ended = Eval(arguments);
    CHECK(ended.exit_code == 0);
    return nlohmann::json::parse(ended.output);
  }
};

}  // namespace

TEST_CASE("slam_eval relations prints a table, from the file or from the folder that holds it") {
  const Fixture fixture;
  const Ended file = fixture.Eval({"relations", fixture.trajectory, fixture.relations});
  CHECK(file.exit_code == 0);
  CHECK(file.output ==
        "relations used 1, missing 1\n"
        "error                  mean       std    median       max\n"
        "translation [m]      0.0500    0.0000    0.0500    0.0500\n"
        "rotation [rad]       0.0000    0.0000    0.0000    0.0000\n"
        "rotation [deg]       0.0000    0.0000    0.0000    0.0000\n");
  CHECK(fixture.Eval({"relations", fixture.folder / "", fixture.relations}).output == file.output);
}

TEST_CASE("slam_eval relations shifts the laser's poses to the robot's centre and prints JSON") {
  const Fixture fixture;
  // A laser 0.1 m behind the centre: the robot goes from (0.1, 0) to (2, 0.1), so from its start by (1.9, 0.1).
  const auto json = fixture.Json({"relations", fixture.trajectory, fixture.relations, "--laser-x-m", "-0.1"});
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
  const Ended text = fixture.Eval({"world", "env2"});
  CHECK(text.exit_code == 0);
  CHECK(text.output == LoadWorldText("env2"));
  const std::string file = fixture.folder / "edited.world";
  std::ofstream(file) << text.output << "person 11 3 11 9 0.5\n";
  const std::string picture = fixture.folder / "world.png";
  CHECK(fixture.Eval({"world", file, "--out", picture}).exit_code == 0);
  CHECK(ReadFile(picture).substr(1, 3) == "PNG");
}

TEST_CASE("slam_eval map and trajectory measure what slam_offline leaves of a simulated world") {
  const Fixture fixture;
  const std::string world = fixture.folder / "room.world";
  std::ofstream(world) << "box 0 0 5 4\nbox 2 2.4 0.8 0.7\nbox 3.4 0 0.5 0.6\nlaser 270 270 9.5 5 0.01\nspeed 0.3 0.5\n"
                          "waypoint 1 1.4\nwaypoint 2.4 1.4\ncorner box 2 2.4\ncorner room 5 4\n";
  const std::string out = fixture.folder / "out";
  fixture.folder.Map("sim:" + world, "out", {"--preset", "paper"});

  const auto map = fixture.Json({"map", out, world});
  CHECK(map["omse_px2"] < 2.0);  // a wall's cells are off by one or so: the noise is half a cell
  CHECK(map["cmse_px2"] < 3.5);
  CHECK(map["obstacles"] > 100);
  CHECK(map["corners"].size() == 2);
  CHECK(map["corners"][0]["name"] == "box");
  CHECK(map["mean_fitness"] == fixture.folder.Summary("out")["mean_fitness"]);
  CHECK(fixture.Eval({"map", out, world}).output.starts_with("OMSE "));

  const auto trajectory = fixture.Json({"trajectory", out});
  CHECK(trajectory["poses"] > 20);
  CHECK(trajectory["mean_m"] < 0.04);
  CHECK(fixture.Eval({"trajectory", out + "/truth.tum"}).output.find("mean 0.0000") != std::string::npos);
  CHECK(fixture.Json({"trajectory", out + "/trajectory.tum", out + "/truth.tum"}) == trajectory);

  // A corner where nothing is: the map is not given a figure.
  std::ofstream(world, std::ios::app) << "box 20 20 1 1\ncorner nowhere 20 20\n";
  fixture.folder.CheckRefused("slam_eval", {"map", out, world},
                              "1 of the 3 corners of " + world + " are not in the map of " + out + ": nowhere", 1);
}

TEST_CASE("slam_eval summary prints a line for each run, and names the folders that have none") {
  const Fixture fixture;
  for (
      const auto& [name, json] : std::map<std::string, std::string>{
          {"a",
           R"({"scans": 4934, "floating": 3, "lost": 2, "without_rays": 1, "left_out": 7, "mean_fitness": 0.91349, "verdict": {"trust": "good"},
                     "loops": {"closed": 12}, "wall_s": 3.14159})"},
          {"long, name",
           R"({"scans": 5, "floating": 0, "lost": 0, "without_rays": 0, "left_out": 0, "mean_fitness": 0.5,
                             "verdict": {"trust": "doubtful"}})"},
          {"bad", R"({"scans": 5})"}}) {
    fs::create_directories(fixture.folder / name);
    std::ofstream(fixture.folder / name / "summary.json") << json;
  }
  const auto Run = [&](const std::string& arguments) {  // from within the folder, whose name is another each time
    return fixture.folder.Run("/bin/sh", {"-c", "cd " + (fixture.folder / "").string() +
                                                    " && " CRSM_BIN_DIR "/slam_eval summary " + arguments});
  };
  const Ended table = Run("a 'long, name'");
  CHECK(table.exit_code == 0);
  CHECK(table.output ==
        "run         verdict   scans  floating  lost  without_rays  left_out  loops  fitness  wall_s\n"
        "a           good       4934         3     2             1         7     12    0.913     3.1\n"
        "long, name  doubtful      5         0     0             0         0      -    0.500       -\n");
  CHECK(Run("--csv 'long, name' a").output ==
        "run,verdict,scans,floating,lost,without_rays,left_out,loops,fitness,wall_s\n"
        "\"long, name\",doubtful,5,0,0,0,0,-,0.500,-\n"
        "a,good,4934,3,2,1,7,12,0.913,3.1\n");
  const Ended with_bad = Run("bad a nowhere");
  CHECK(with_bad.exit_code == 1);
  CHECK(with_bad.output == Run("a").output);
  CHECK(with_bad.errors ==
        "slam_eval: 2 of 3 runs have no summary: bad/summary.json: must have the numbers scans, floating, lost, "
        "without_rays, left_out and mean_fitness, and a verdict: is it of an older version?; cannot read "
        "nowhere/summary.json: No such file or directory\n");
}

TEST_CASE("slam_eval says what is wrong in one line, and exits 2 where the flags are") {
  const Fixture fixture;
  const TemporaryFolder& folder = fixture.folder;
  const auto Write = [&](const std::string& name, const std::string& content) {
    const std::string path = folder / name;
    fs::create_directories(fs::path(path).parent_path());
    std::ofstream(path) << content;
    return path;
  };
  const std::string bad = Write("bad.relations", "1 2 3\n");
  const std::string empty = Write("empty.relations", "");
  const std::string no_origin = folder / "no_origin";
  const std::string no_png = folder / "no_png";
  Write("no_origin/map.yaml", "resolution: 0.05\n");
  Write("no_png/map.yaml", "resolution: 0.05\norigin: [0, 0, 0]\n");
  const std::string& trajectory = fixture.trajectory;
  const std::string& relations = fixture.relations;
  struct Case {
    std::vector<std::string> arguments;
    std::string expected;
    int exit_code = 1;
  };
  for (const Case& one :
       std::vector<Case>{{{}, "subcommand", 2},
                         {{"nonsense"}, "subcommand", 2},
                         {{"relations", trajectory}, "RELATIONS", 2},
                         {{"world", "nowhere"}, "there is no world file nowhere"},
                         {{"world", "env1", "--out", "/no/such/folder/w.png"}, "cannot write /no/such/folder/w.png"},
                         {{"world", "env1", "--cell-size-m", "nan", "--out", "/dev/null"}, "--cell-size-m", 2},
                         {{"trajectory", trajectory}, "truth.tum"},
                         {{"plan", folder / ""}, "--out is missing", 2},
                         {{"plan", folder / "", "--out", folder / "plan.jpg"}, "must end in .svg, .pdf or .dxf", 2},
                         {{"plan", folder / "", "--out", folder / "plan.svg"}, "journal"},
                         {{"plan", folder / "", "--out", folder / "p.svg", "--paper", "a5"}, "must be a4 or a3", 2},
                         {{"plan", folder / "", "--out", folder / "p.svg", "--scale", "nan"}, "--scale", 2},
                         {{"plan", folder / "", "--out", folder / "p.svg", "--scale", "0.5"}, "whole number", 2},
                         {{"map", folder / "", "env1"}, "map.yaml"},
                         {{"map", no_origin, "env1"}, "map.yaml: must have lines"},
                         {{"map", no_png, "env1"}, "map.png: No such file or directory"},
                         {{"relations", "/no/such.tum", relations}, "/no/such.tum"},
                         {{"relations", trajectory, "/no/such.relations"}, "/no/such.relations"},
                         {{"relations", trajectory, bad}, "bad.relations:1: must be the eight numbers"},
                         {{"relations", trajectory, empty}, "none of the 0 relations"},
                         {{"relations", trajectory, relations, "--laser-x-m", "nan"}, "--laser-x-m", 2},
                         {{"relations", trajectory, relations, "--laser-x-m", "11"}, "within -10 and 10", 2},
                         {{"relations", trajectory, relations, "--laser-x-m", "near"}, "--laser-x-m", 2}}) {
    folder.CheckRefused("slam_eval", one.arguments, one.expected, one.exit_code);
  }
  CHECK(fixture.Eval({"relations", "--help"}).exit_code == 0);
}

TEST_CASE(
    "slam_eval plan draws the plan of a finished run as SVG, PDF and DXF, with names, and refuses what does not fit") {
  const TemporaryFolder folder;
  const std::string run = folder / "run";
  REQUIRE(folder.Run("slam_offline", {CRSM_SOURCE_DIR "/logs/corridor.lcm", "--out", run}).exit_code == 0);
  std::ofstream(folder / "names") << "0.5 0 start\n";
  for (const auto& [name, start] :
       {std::pair("a.svg", "<?xml"), std::pair("a.pdf", "%PDF-"), std::pair("a.dxf", "0\nSECTION\n")}) {
    const Ended ended = folder.Run("slam_eval", {"plan", run, "--out", folder / name, "--names", folder / "names"});
    CHECK(ended.exit_code == 0);
    CHECK(ended.errors == "");
    CHECK(ended.output.find(std::string(name) + ": ") != std::string::npos);
    CHECK(ended.output.find(" walls of ") != std::string::npos);
    CHECK(ReadFile(folder / name).starts_with(start));
  }
  const auto Refuse = [&](const std::vector<std::string>& more, const std::string& expected, int exit_code) {
    std::vector<std::string> arguments{"plan", run, "--out", folder / "b.svg"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    folder.CheckRefused("slam_eval", arguments, expected, exit_code);
    CHECK_FALSE(fs::exists(folder / "b.svg"));
  };
  Refuse({"--scale", "1"}, "or smaller", 2);
  std::ofstream(folder / "bad") << "1 here\n";
  Refuse({"--names", folder / "bad"}, "bad line 1: must be a place", 1);
  Refuse({"--names", folder / "none"}, "No such file", 1);
  const std::string localised = folder / "localised";
  REQUIRE(folder.Run("slam_offline", {CRSM_SOURCE_DIR "/logs/corridor.lcm", "--out", localised, "--localize", run})
              .exit_code == 0);
  folder.CheckRefused("slam_eval", {"plan", localised, "--out", folder / "b.svg"}, "give the folder of that run", 1);
  folder.CheckRefused("slam_eval", {"plan", run, "--out", run}, "must end in", 2);
}
