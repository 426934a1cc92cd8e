// What every program says when it is called wrongly: one line that names the thing, and an exit code that is not 0.

#include <fstream>
#include <sstream>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

std::string Repeat(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

constexpr int kFailure = 1;  ///< exit code where the flags are right, and what they name is not

const std::vector<std::string> kServices{"ray_selector", "rrhc_matcher", "map_updater", "loop_closer", "map_exporter"};

/// A folder with files that are not what a program wants.
class BadFiles : public TemporaryFolder {
 public:
  BadFiles() {
    std::filesystem::create_directories(TemporaryFolder::operator/("directory"));
    for (const auto& [name, content] :
         std::map<std::string, std::string>{{"empty.log", ""},
                                            {"text.log", "this is\nno log\n"},
                                            {"file", "a regular file"},
                                            {"unknown.toml", "rays_max = 90\nnonesuch = 3\n"},
                                            {"range.toml", "seed = 7\n\nrays_max = 1\n"},
                                            {"type.toml", "rays_max = \"60\"\n"},
                                            {"syntax.toml", "rays_max = \n"},
                                            {"long.toml", "a" + Repeat(".a", 50'000) + " = 1\n"}}) {
      std::ofstream(TemporaryFolder::operator/(name)) << content;
    }
  }
  std::string operator/(const std::string& name) const { return TemporaryFolder::operator/(name); }
};

}  // namespace

TEST_CASE("every program has --help and --version") {
  const TemporaryFolder folder;
  for (const std::string program : {"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater", "loop_closer",
                                    "map_exporter", "map_viewer", "slam_offline", "slam_eval", "run_stack"}) {
    for (const std::string flag : {"--help", "--version"}) {
      INFO(program << ' ' << flag);
      const Ended ended = folder.Run(program, {flag});
      CHECK(ended.exit_code == 0);
      CHECK(ended.output.find(flag == "--help" ? "--version" : program + " ") != std::string::npos);
      CHECK(ended.errors.empty());
      std::istringstream lines(ended.output);
      for (std::string line; std::getline(lines, line);) {
        CAPTURE(line);
        CHECK(line.size() <= 100);
      }
    }
  }
}

TEST_CASE("a source that is mistyped, incomplete or of another program is answered with what to give") {
  BadFiles files;
  struct Case {
    std::string program;
    std::string source;
    std::string expected;
    int exit_code;
  };
  for (const Case& one : std::vector<Case>{
           {"slam_offline", "live", "slam_offline: live: only run_stack maps the scans of another program", 2},
           {"laser_publisher", "live", "run_stack live --out DIR", 2},
           {"run_stack", "rplidar", "run_stack: rplidar: the port of the laser is missing: give rplidar:/dev/", 2},
           {"run_stack", "lvie", "there is no file lvie; did you mean live?", kFailure},
           {"slam_offline", files / "txt.log", "; did you mean " + (files / "text.log") + "?", kFailure}}) {
    std::vector<std::string> arguments{one.source};
    if (one.program != "laser_publisher") arguments.insert(arguments.end(), {"--out", files / "out"});
    files.CheckRefused(one.program, arguments, one.expected, one.exit_code);
  }
}

TEST_CASE("a URL that is no bus stops every service") {
  BadFiles files;
  for (const auto& [program, own] :
       std::map<std::string, std::vector<std::string>>{{"ray_selector", {}},
                                                       {"rrhc_matcher", {}},
                                                       {"map_updater", {}},
                                                       {"map_exporter", {"--out", files / "out"}},
                                                       {"map_viewer", {"--http", "127.0.0.1:0"}},
                                                       {"laser_publisher", {"sim:demo"}}}) {
    for (const std::string url :
         {"garbage", "nosuch://239.255.76.67:7667", "udpm://no.such.host:7667", "udpm://127.0.0.1:7667",
          "udpm://239.255.76.67:0", "udpm://239.255.76.67:99999", "udpm://239.255.76.67:7667?ttl=abc",
          "udpm://239.255.76.67:7667?tll=1", "memq://", "udpm://239.255.76.67:7667?ttl=1&",
          "udpm://239.255.76.67:7667?", "udpm://239.255.76.67:"}) {
      std::vector<std::string> arguments = own;
      arguments.insert(arguments.end(), {"--lcm-url", url});
      files.CheckRefused(program, arguments, "--lcm-url " + url + ": is no bus between processes");
    }
  }
  files.CheckRefused("ray_selector", {"--lcm-url", "file://run.lcm?mode=w"}, "is no bus between processes");
}

TEST_CASE("a source that has no scans stops those who read it, by name") {
  BadFiles files;
  for (const std::string program : {"laser_publisher", "slam_offline"}) {
    for (const auto& [source, expected] :
         std::map<std::string, std::string>{{files / "nonesuch.log", "nonesuch.log"},
                                            {files / "directory", "is a directory"},
                                            {files / "empty.log", "empty.log is empty"},
                                            {files / "text.log", "text.log is neither a CARMEN log"},
                                            {"sim:nonesuch", "nonesuch"},
                                            {"sim:" + (files / "text.log"), "text.log:1: "}}) {
      std::vector<std::string> arguments{source};
      if (program == "slam_offline") arguments.insert(arguments.end(), {"--out", files / "out"});
      files.CheckRefused(program, arguments, expected, kFailure);
    }
    files.CheckRefused(program, {}, "SOURCE");
  }
}

TEST_CASE("a rate that is none stops the publisher") {
  BadFiles files;
  for (const std::string rate : {"0", "-1", "nan", "abc", "inf", "1x", ""}) {
    files.CheckRefused("laser_publisher", {"sim:demo", "--rate", rate, "--lcm-url", MakeBusUrl()},
                       "--rate: '" + rate + "' is neither max nor a number above 0");
  }
}

TEST_CASE("a folder that is missing or cannot be written is refused before any work") {
  BadFiles files;
  files.CheckRefused("map_exporter", {"--lcm-url", MakeBusUrl()}, "--out is missing");
  files.CheckRefused("slam_offline", {"sim:demo"}, "--out is missing");
  for (const std::string& out : {files / "file", files / "file/below"}) {
    files.CheckRefused("map_exporter", {"--lcm-url", MakeBusUrl(), "--out", out}, "--out " + out, kFailure);
    files.CheckRefused("slam_offline", {"sim:demo", "--out", out}, "--out " + out, kFailure);
  }
}

TEST_CASE("a log that cannot be written, or that is the one to be read, is refused") {
  BadFiles files;
  const std::string log = files.Write(TakeScans("sim:demo", 3), "run.lcm");
  const std::string before = ReadFile(log);
  files.CheckRefused("laser_publisher", {log, "--lcm-url", "file://" + log}, "use file://PATH?mode=w");
  files.CheckRefused("laser_publisher", {log, "--lcm-url", "file://" + log + "?mode=w"},
                     "would overwrite " + log + ", which is read");
  files.CheckRefused("laser_publisher", {files / "run.*", "--lcm-url", "file://" + log + "?mode=w"},
                     "would overwrite " + log + ", which is read");
  files.CheckRefused("laser_publisher", {log, "--lcm-url", "file://" + (files / "file/below") + "?mode=w"},
                     "file/below", kFailure);
  files.CheckRefused("laser_publisher", {log, "--lcm-url", "file://" + (files / "directory") + "?mode=w"}, "directory",
                     kFailure);
  CHECK(ReadFile(log) == before);
}

TEST_CASE("a configuration file stops the program with the line and the key that are wrong") {
  BadFiles files;
  for (const std::string& service : kServices) {
    for (const auto& [file, expected] : std::map<std::string, std::string>{
             {"unknown.toml", "unknown.toml:2: nonesuch: no such key"},
             {"range.toml", "range.toml:3: rays_max: '1' is not a whole number from 6 to 4096"},
             {"type.toml", "type.toml:1: rays_max"},
             {"syntax.toml", "syntax.toml:1: "},
             {"long.toml", "long.toml:1: is longer than 10000 characters"},
             {"nonesuch.toml", "nonesuch.toml: "},
             {"directory", "directory: "}}) {
      files.CheckRefused(service, {"--lcm-url", MakeBusUrl(), "--config", files / file}, expected);
    }
  }
}

TEST_CASE("a flag that is unknown or out of range is named") {
  BadFiles files;
  struct Case {
    std::string program;
    std::vector<std::string> arguments;
    std::string expected;
  };
  for (const Case& one : std::vector<Case>{
           {"ray_selector", {"--nonesuch"}, "--nonesuch"},
           {"ray_selector", {"stray"}, "stray"},
           {"ray_selector", {"--laser-channel", "LIDAR*"}, "--laser-channel LIDAR*: must name one channel"},
           {"ray_selector", {"--laser-channel", Repeat("x", 64)}, Repeat("x", 64) + ": must name one channel"},
           {"ray_selector", {"--rays-max", "1"}, "--rays-max: '1' is not a whole number from 6 to 4096"},
           {"ray_selector", {"--range-min-m", "5", "--range-max-m", "4"}, "range_min_m: 5 is more than range_max_m, 4"},
           {"map_updater", {"--resume", "--lcm-url", MakeBusUrl()}, "--resume needs --journal DIR"},
           {"slam_offline", {"sim:demo", "--out", files / "out", "--start", "1,2,3"}, "--start: needs a finished map"},
           {"slam_eval", {}, "A subcommand is required"},
           {"slam_eval", {"relations", "run", "run.relations", "--laser-x-m", "11"}, "--laser-x-m is 11"},
           {"rrhc_matcher", {"--seed", "-1"}, "--seed: '-1' is not a whole number from 0"},
           {"rrhc_matcher", {"--seed"}, "--seed"},
           {"rrhc_matcher", {"--preset", "best"}, "--preset: 'best' is not one of"},
           {"rrhc_matcher", {"--profile", "best"}, "--profile: 'best' is not one of"},
           {"map_updater", {"--cell-size-m", "nan"}, "--cell-size-m: 'nan' is not a number from"},
           {"map_updater", {"--cell-size-m", "0"}, "--cell-size-m: '0' is not a number from"},
           {"map_exporter", {"--export-period-s", "0"}, "--export-period-s: '0' is not a number from"}}) {
    files.CheckRefused(one.program, one.arguments, one.expected);
  }
}
