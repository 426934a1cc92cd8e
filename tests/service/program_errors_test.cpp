// What every program says when it is called wrongly: one line that names the thing, and an exit code that is not 0.

#include <algorithm>
#include <fstream>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

// Exit codes: the program was called wrongly, or what it was called with is not as it should be.
constexpr int kUsage = 2;
constexpr int kFailure = 1;

const std::vector<std::string> kServices{"ray_selector", "rrhc_matcher", "map_updater", "loop_closer", "map_exporter"};

/// A folder with files that are not what a program wants.
class BadFiles {
 public:
  BadFiles() {
    std::filesystem::create_directories(folder_ / "directory");
    Write("empty.log", "");
    Write("text.log", "this is\nno log\n");
    Write("file", "a regular file");
    Write("unknown.toml", "rays_max = 90\nnonesuch = 3\n");
    Write("range.toml", "seed = 7\n\nrays_min = 1\n");
    Write("type.toml", "rays_min = \"60\"\n");
    Write("syntax.toml", "rays_min = \n");
  }
  std::string operator/(const std::string& name) const { return folder_ / name; }

  /// Checks that a program refuses these arguments in one line that begins with its name and has `expected`.
  void CheckRefused(const std::string& program, const std::vector<std::string>& arguments, const std::string& expected,
                    int expected_code = kUsage) {
    Process process(program, arguments, folder_ / "log");
    const int exit_code = process.AwaitExit();
    const std::string errors = process.errors();
    INFO(program << ' ' << Catch::Detail::stringify(arguments) << '\n' << errors);
    CHECK(exit_code == expected_code);
    CHECK(std::count(errors.begin(), errors.end(), '\n') == 1);
    CHECK(errors.find(program + ": ") == 0);
    CHECK(errors.find(expected) != std::string::npos);
    CHECK(process.output().empty());
  }

 private:
  void Write(const std::string& name, const std::string& content) { std::ofstream(folder_ / name) << content; }

  TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("every program has --help and --version") {
  const TemporaryFolder folder;
  for (const std::string program : {"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater", "loop_closer",
                                    "map_exporter", "map_viewer", "slam_offline", "slam_eval", "run_stack"}) {
    for (const std::string flag : {"--help", "--version"}) {
      INFO(program << ' ' << flag);
      Process process(program, {flag}, folder / "log");
      CHECK(process.AwaitExit() == 0);
      CHECK(process.output().find(flag == "--help" ? "--version" : program + " ") != std::string::npos);
      CHECK(process.errors().empty());
    }
  }
}

TEST_CASE("a URL that is no bus stops every service") {
  BadFiles files;
  for (std::vector<std::string> arguments : {std::vector<std::string>{"ray_selector"},
                                             {"rrhc_matcher"},
                                             {"map_updater"},
                                             {"map_exporter", "--out", files / "out"},
                                             {"map_viewer", "--http", "127.0.0.1:0"},
                                             {"laser_publisher", "sim:demo"}}) {
    const std::string program = arguments.front();
    arguments.erase(arguments.begin());
    arguments.push_back("--lcm-url");
    for (const std::string url : {"garbage", "nosuch://239.255.76.67:7667", "udpm://no.such.host:7667",
                                  "udpm://127.0.0.1:7667", "udpm://239.255.76.67:0", "udpm://239.255.76.67:99999",
                                  "udpm://239.255.76.67:7667?ttl=abc", "udpm://239.255.76.67:7667?tll=1", "memq://"}) {
      arguments.push_back(url);
      files.CheckRefused(program, arguments, "--lcm-url " + url + ": is no bus between processes");
      arguments.pop_back();
    }
  }
  files.CheckRefused("ray_selector", {"--lcm-url", "file://run.lcm?mode=w"}, "is no bus between processes");
}

TEST_CASE("a source that has no scans stops those who read it, by name") {
  BadFiles files;
  for (const std::string program : {"laser_publisher", "slam_offline"}) {
    const auto CheckRefused = [&](const std::string& source, const std::string& expected) {
      std::vector<std::string> arguments{source};
      if (program == "slam_offline") arguments.insert(arguments.end(), {"--out", files / "out"});
      files.CheckRefused(program, arguments, expected, kFailure);
    };
    CheckRefused(files / "nonesuch.log", "nonesuch.log");
    CheckRefused(files / "directory", "is a directory");
    CheckRefused(files / "empty.log", "empty.log is empty");
    CheckRefused(files / "text.log", "text.log is neither a CARMEN log");
    CheckRefused("sim:nonesuch", "nonesuch");
    CheckRefused("sim:" + (files / "text.log"), "text.log:1: ");
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
  const std::string log = files / "run.lcm";
  WriteScans(TakeScans("sim:demo", 3), log);
  const std::string before = ReadFile(log);
  files.CheckRefused("laser_publisher", {log, "--lcm-url", "file://" + log}, "use file://PATH?mode=w");
  files.CheckRefused("laser_publisher", {log, "--lcm-url", "file://" + log + "?mode=w"},
                     "would overwrite the log that is read");
  files.CheckRefused("laser_publisher", {log, "--lcm-url", "file://" + (files / "file/below") + "?mode=w"},
                     "file/below", kFailure);
  files.CheckRefused("laser_publisher", {log, "--lcm-url", "file://" + (files / "directory") + "?mode=w"}, "directory",
                     kFailure);
  CHECK(ReadFile(log) == before);
}

TEST_CASE("a configuration file stops the program with the line and the key that are wrong") {
  BadFiles files;
  for (const std::string& service : kServices) {
    const auto CheckRefused = [&](const std::string& file, const std::string& expected) {
      files.CheckRefused(service, {"--lcm-url", MakeBusUrl(), "--config", files / file}, expected);
    };
    CheckRefused("unknown.toml", "unknown.toml:2: nonesuch: no such key");
    CheckRefused("range.toml", "range.toml:3: rays_min: '1' is not a whole number from 2 to 4096");
    CheckRefused("type.toml", "type.toml:1: rays_min");
    CheckRefused("syntax.toml", "syntax.toml:1: ");
    CheckRefused("nonesuch.toml", "nonesuch.toml: ");
    CheckRefused("directory", "directory: ");
  }
}

TEST_CASE("a flag that is unknown or out of range is named") {
  BadFiles files;
  files.CheckRefused("ray_selector", {"--nonesuch"}, "--nonesuch");
  files.CheckRefused("ray_selector", {"stray"}, "stray");
  files.CheckRefused("ray_selector", {"--rays-min", "1"}, "--rays-min: '1' is not a whole number from 2 to 4096");
  files.CheckRefused("ray_selector", {"--range-min-m", "5", "--range-max-m", "4"},
                     "range_min_m: 5 is more than range_max_m, 4");
  files.CheckRefused("map_updater", {"--intensity-min", "0.5", "--intensity-max", "0.1"},
                     "intensity_min: 0.5 is more than intensity_max, 0.1");
  files.CheckRefused("map_updater", {"--resume", "--lcm-url", MakeBusUrl()}, "--resume needs --journal DIR");
  files.CheckRefused("slam_offline", {"sim:demo", "--out", files / "out", "--start", "1,2,3"},
                     "--start: needs a finished map: add --localize DIR");
  files.CheckRefused("slam_eval", {}, "A subcommand is required");
  files.CheckRefused("slam_eval", {"relations", "run", "run.relations", "--laser-x-m", "11"}, "--laser-x-m is 11");
  files.CheckRefused("ray_selector", {"--rays-min", "91"}, "rays_min: 91 is more than rays_max, 90");
  files.CheckRefused("ray_selector", {"--method", "best"}, "--method: 'best' is not one of all, uniform");
  files.CheckRefused("rrhc_matcher", {"--seed", "-1"}, "--seed: '-1' is not a whole number from 0");
  files.CheckRefused("rrhc_matcher", {"--window-m", "nan"}, "--window-m: 'nan' is not a number from");
  files.CheckRefused("rrhc_matcher", {"--seed"}, "--seed");
  files.CheckRefused("rrhc_matcher", {"--preset", "best"}, "--preset: 'best' is not one of");
  files.CheckRefused("rrhc_matcher", {"--profile", "best"}, "--profile: 'best' is not one of");
  files.CheckRefused("map_updater", {"--cell-size-m", "0"}, "--cell-size-m: '0' is not a number from");
  files.CheckRefused("map_exporter", {"--export-period-s", "0"}, "--export-period-s: '0' is not a number from");
}
