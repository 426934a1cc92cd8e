#include "services/settings/command_line.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include "catch.hpp"
#include "services/settings/help.hpp"
#include "source_helpers.hpp"

namespace crsm {
namespace {

/// How a program with all parameters and settings fares with these words.
class Program {
 public:
  explicit Program(const std::vector<std::string>& words,
                   std::vector<ParameterGroup> groups = {ParameterGroup::kSeed, ParameterGroup::kLaser,
                                                         ParameterGroup::kScan, ParameterGroup::kSelection,
                                                         ParameterGroup::kUpdate, ParameterGroup::kLoops,
                                                         ParameterGroup::kAlgorithm})
      : line("program", "What it does.", std::move(groups),
             {"lcm_url", "channel_prefix", "odometry", "odometry_topic", "lockstep", "map_wait_s", "start"}) {
    std::vector<const char*> argv{"program"};
    for (const std::string& word : words) argv.push_back(word.c_str());
    said = Capture([&] { exit_code = line.Parse(static_cast<int>(argv.size()), argv.data()); });
  }

  const Parameters& parameters() const { return line.parameters(); }
  bool Says(const std::string& text) const { return said.find(text) != std::string::npos; }

  CommandLine line;
  std::optional<int> exit_code;
  std::string said;  ///< on stderr and stdout

 private:
  template <class Call>
  static std::string Capture(Call call) {
    const ScratchFile file("");
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(file.path().c_str(), "w"), &std::fclose);
    const auto Flush = [] { std::cout.flush(), std::fflush(stdout), std::fflush(stderr); };
    Flush();
    const int kept_out = dup(STDOUT_FILENO);
    const int kept_err = dup(STDERR_FILENO);
    dup2(fileno(out.get()), STDOUT_FILENO);
    dup2(fileno(out.get()), STDERR_FILENO);
    call();
    Flush();
    dup2(kept_out, STDOUT_FILENO);
    dup2(kept_err, STDERR_FILENO);
    close(kept_out);
    close(kept_err);
    std::ifstream in(file.path());
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

/// Refuses in one line that names the program and holds `text`.
void CheckRefused(const Program& program, const std::string& text) {
  CAPTURE(text, program.said);
  CHECK(program.exit_code == 2);
  CHECK(program.said.rfind("program: ", 0) == 0);
  CHECK(program.Says(text));
  CHECK(std::count(program.said.begin(), program.said.end(), '\n') == 1);
}

/// What is said of a wrong command line; empty if it is right.
std::string ParseErrorOf(CLI::App& app, const std::string& words) {
  try {
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    return DescribeParseError(app, error);
  }
  return "";
}

}  // namespace

TEST_CASE("without flags the defaults hold") {
  const Program program({});
  CHECK_FALSE(program.exit_code);
  CHECK(program.said.empty());
  CHECK(ListParameters(program.parameters()) == ListParameters(Parameters()));
}

TEST_CASE("a program tells the values of what it uses, and of nothing else") {
  const Program program({"--seed", "7", "--lockstep", "--map-wait-s", "0.5"}, {ParameterGroup::kSeed});
  const NamedValues expected{{"seed", std::uint64_t{7}}, {"lcm_url", ""},    {"channel_prefix", ""}, {"odometry", true},
                             {"odometry_topic", ""},     {"lockstep", true}, {"map_wait_s", 0.5},    {"start", ""}};
  CHECK(program.line.UsedValues() == expected);
}

TEST_CASE("a value as text is the same value again, for every parameter and setting") {
  Program program({"--algorithm", "paper", "--cell-size-m", "0.07", "--no-loops", "--seed", "18446744073709551615",
                   "--lcm-url", "7"});
  for (const auto& [key, value] : program.line.UsedValues()) {
    INFO(key << ": " << FormatValue(value));
    CHECK(ReadValue(key, FormatValue(value)) == value);
  }
}

TEST_CASE("a text that is no value of its key, or of a key that is unknown, stays a text") {
  CHECK(ReadValue("seed", "abc") == ParameterValue{std::string("abc")});
  CHECK(ReadValue("cell_size_m", "nan") == ParameterValue{std::string("nan")});
  CHECK(ReadValue("of_another_matcher", "5") == ParameterValue{std::string("5")});
}

TEST_CASE("every kind of flag sets its value") {
  const Program program({"--cell-size-m", "0.07", "--rays-max=123", "--algorithm", "paper", "--no-beam-times",
                         "--no-loops", "--seed", "18446744073709551615", "--lcm-url", "tcpq://localhost", "--lockstep",
                         "--map-wait-s", "1.5", "--sweep-s", "-0.1"});
  CHECK_FALSE(program.exit_code);
  CHECK(program.said.empty());
  CHECK(program.parameters().update.cell_size_m == 0.07);
  CHECK(program.parameters().selection.rays_max == 123);
  CHECK(program.parameters().update.algorithm == Algorithm::kPaper);
  CHECK_FALSE(program.parameters().scan.beam_times);
  CHECK_FALSE(program.parameters().loops.loops);
  CHECK(program.parameters().match.seed == ~std::uint64_t{0});
  CHECK(program.parameters().scan.sweep_s == -0.1);
  CHECK(program.line.settings().lcm_url == "tcpq://localhost");
  CHECK(program.line.settings().lockstep);
  CHECK(program.line.settings().map_wait_s == 1.5);
}

TEST_CASE("a flag wins over the file, the file over the preset") {
  const ScratchFile config("range_max_m = 7.0\nseed = 5\n");
  const Program preset({"--preset", "paper"});
  CHECK(preset.parameters().scan.range_max_m == 9.5);     // section 4: "up to 9.5 meters"
  CHECK(preset.parameters().update.cell_size_m == 0.02);  // section 5.3: "one pixel has a side of 0.02 m"
  const Program file({"--preset", "paper", "--config", config.path()});
  CHECK(file.parameters().scan.range_max_m == 7.0);
  CHECK(file.parameters().update.cell_size_m == 0.02);
  const Program flag({"--range-max-m", "8", "--config", config.path(), "--preset", "paper"});
  CHECK(flag.parameters().scan.range_max_m == 8.0);
  CHECK(flag.parameters().match.seed == 5);
}

TEST_CASE("the file and flags win over the profile, and the preset leaves the profile's own alone") {
  const ScratchFile config("update_distance_m = 0.7\n");
  const Program program({"--profile", "paper", "--preset", "sick", "--config", config.path(), "--loops"});
  CHECK_FALSE(program.exit_code);
  CHECK(program.parameters().update.update_distance_m == 0.7);
  CHECK(program.parameters().update.update_angle_rad == 0.0);
  CHECK(program.parameters().update.algorithm == Algorithm::kPaper);
  CHECK(program.parameters().loops.loops);
}

TEST_CASE("every preset and profile is well-formed") {
  for (const char* preset : {"sick", "urg-04lx", "utm-30lx", "paper"}) {
    CHECK_FALSE(Program({"--preset", preset, "--profile", "default"}).exit_code);
  }
}

TEST_CASE("a file may hold what is another program's, and it is checked all the same") {
  const ScratchFile good(
      "# for all\nrays_max = 9\nexport_period_s = 2\nloops = true\nalgorithm = \"paper\"\nout = \"a\"\n");
  const Program program({"--config", good.path()}, {ParameterGroup::kScan});
  CHECK_FALSE(program.exit_code);
  CHECK(program.parameters().selection.rays_max == 9);
  CHECK(program.line.settings().export_period_s == 2.0);
  const ScratchFile bad("\nrays_max = 0\n");
  CheckRefused(Program({"--config", bad.path()}, {ParameterGroup::kScan}),
               bad.path() + ":2: rays_max: '0' is not a whole number from 6");
}

TEST_CASE("a file that is wrong is refused in one line that names the file, the line, the key and the mend") {
  const std::pair<const char*, const char*> cases[] = {
      {"seed = 1\nsed = 2\n", ":2: sed: no such key"},
      {"cell_size_m = 5.0\n", ":1: cell_size_m: '5' is not a number from 0.005 to 1"},
      {"cell_size_m = nan\n", ":1: cell_size_m: 'nan' is not a number from 0.005 to 1"},
      {"cell_size_m = \"0.05\"\n", ":1: cell_size_m: '0.05' is not a number"},
      {"rays_max = 10.5\n", ":1: rays_max: '10.5' is not a whole number"},
      {"rays_max = 99999999999\n", ":1: rays_max: '99999999999' is not a whole number"},
      {"seed = -1\n", ":1: seed: '-1' is not a whole number from 0"},
      {"loops = 1\n", ":1: loops: '1' is not true or false"},
      {"loops = \"true\"\n", ":1: loops: 'true' is not true or false"},
      {"algorithm = \"best\"\n", ":1: algorithm: 'best' is not one of crsm, paper"},
      {"algorithm = 2\n", ":1: algorithm: '2' is not one of crsm, paper"},
      {"channel_prefix = 3\n", ":1: channel_prefix: '3' is not a string in quotes"},
      {"\n\nseed = [1, 2]\n", ":3: seed: '(a table or a list)' is not a whole number"},
      {"[match]\nseed = 1\n", ":1: match: no such key"},
      {"seed = 1\nseed == 2\n", ":2: "},
      {"seed = 1\nseed = 2\n", ":2: "},
  };
  for (const auto& [text, expected] : cases) {
    const ScratchFile config(text);
    CheckRefused(Program({"--config", config.path()}), config.path() + expected);
  }
}

TEST_CASE("a prefix leaves room for the longest channel, and a configuration is a file that ends") {
  CHECK_FALSE(Program({"--channel-prefix", std::string(33, 'x')}).exit_code);
  CheckRefused(Program({"--channel-prefix", std::string(34, 'x')}), "has 34 characters, must have at most 33");
  CheckRefused(Program({"--config", "/nowhere/a.toml"}), "cannot read /nowhere/a.toml: No such file or directory");
  CheckRefused(Program({"--config", "/dev/zero"}), "cannot read /dev/zero: is no regular file");
  const ScratchFolder folder;
  const std::string fifo = (folder / "fifo").string();
  REQUIRE(mkfifo(fifo.c_str(), 0600) == 0);
  CheckRefused(Program({"--config", fifo}), "cannot read " + fifo + ": is no regular file");
  const ScratchFile empty("");
  CheckRefused(Program({"--config", empty.path()}), empty.path() + ": is empty");
}

TEST_CASE("a file may name preset and profile, which come before its other keys; flags win") {
  const ScratchFile file("range_max_m = 7\npreset = \"sick\"\nprofile = \"paper\"\n");
  const Program both({"--config", file.path()});
  CHECK_FALSE(both.exit_code);
  CHECK(both.parameters().scan.range_max_m == 7.0);
  CHECK(both.parameters().scan.angle_scale == Program({"--preset", "sick"}).parameters().scan.angle_scale);
  CHECK(both.parameters().update.algorithm == Algorithm::kPaper);
  const Program flags({"--config", file.path(), "--preset", "urg-04lx", "--profile", "default"});
  CHECK(flags.parameters().scan.angle_scale == 1.0);
  CHECK(flags.parameters().update.algorithm == Algorithm::kCrsm);
  CHECK(flags.parameters().scan.range_max_m == 7.0);
  const ScratchFile wrong("seed = 3\npreset = \"sikc\"\n");
  CheckRefused(Program({"--config", wrong.path()}),
               wrong.path() + ":2: preset: 'sikc' is not one of paper, rplidar-a1, sick");
  const ScratchFile number("profile = 3\n");
  CheckRefused(Program({"--config", number.path()}), number.path() + ":1: profile: must be a name in quotes");
}

TEST_CASE("what contradicts itself is refused by name") {
  CheckRefused(Program({"--range-min-m", "3", "--range-max-m", "2"}), "range_min_m: 3 is more than range_max_m, 2");
  CHECK_FALSE(Program({"--range-min-m", "3", "--range-max-m", "3"}).exit_code);
  CHECK_FALSE(Program({"--start", "1,2,3"}).exit_code);  // of a program that has no --localize
}

TEST_CASE(
    "odometry is used unless it is turned off; to name it and to turn it off are a contradiction on a command line") {
  const ScratchFile named("odometry_topic = '/odom'\n");
  const ScratchFile off("odometry = false\n");
  const ScratchFile both("odometry = false\nodometry_topic = '/odom'\n");
  const auto Uses = [](const std::vector<std::string>& words) {
    const Program program(words);
    CHECK_FALSE(program.exit_code);
    return program.line.settings().odometry;
  };
  CHECK(Uses({"--odometry-topic", "/odom"}));
  CHECK(Uses({"--odometry-topic", "/odom", "--odometry"}));
  CHECK(Uses({"--config", named.path()}));
  CHECK_FALSE(Uses({"--config", off.path()}));
  CHECK_FALSE(Uses({"--config", named.path(), "--no-odometry"}));
  CHECK_FALSE(Uses({"--config", both.path()}));
  CHECK(Uses({}));
  CheckRefused(Program({"--odometry-topic", "/odom", "--no-odometry"}),
               "--odometry-topic: names odometry that --no-odometry turns off: remove one of them");
  CheckRefused(
      Program({"--config", off.path(), "--odometry-topic", "/odom"}),
      "--odometry-topic: names odometry that " + off.path() + ":1: odometry = false turns off: remove one of them");
}

TEST_CASE("the words for another program are those that it knows, in the order of --help") {
  const Program program(
      {"--seed", "7", "--rays-max", "70", "--preset", "sick", "--lockstep", "--channel-prefix", "robot1/"});
  CHECK(program.line.WordsFor(FlagsOfSelector()) ==
        std::vector<std::string>{"--preset", "sick", "--channel-prefix", "robot1/", "--rays-max", "70"});
  CHECK(program.line.WordsFor(FlagsOfMatcher()) ==
        std::vector<std::string>{"--preset", "sick", "--channel-prefix", "robot1/", "--lockstep", "--seed", "7"});
  CHECK(program.line.WasGiven("seed"));
  CHECK_FALSE(program.line.WasGiven("range_min_m"));
}

TEST_CASE("of what a map is made is said by the names of its logs and the flags that it depends on") {
  const ScratchFile log("a log");
  const std::string name = std::filesystem::path(log.path()).filename().string();
  Program program(
      {"--seed", "7", "--lcm-url", "tcpq://", "--preset", "sick", "--no-loops", "--odometry-topic", "/my odom"});
  program.line.Correct("sweep_s", "-0.1");  // by what the scans show
  CHECK(program.line.DescribeRun({log.path(), "sim:" + log.path(), "sim:demo", "rplidar:/dev/ttyUSB0"}) ==
        name + " sim:" + name +
            " sim:demo rplidar:/dev/ttyUSB0 --preset sick --odometry-topic \"/my odom\" --seed 7 --no-loops");
  CHECK(Program({}).line.DescribeRun({"live"}) == "live");
  const ScratchFile config("seed = 3\n");
  CHECK(Program({"--config", config.path()}).line.DescribeRun({"live"}) ==
        "live --config " + std::filesystem::path(config.path()).filename().string());
}

TEST_CASE("a flag that is wrong is refused in one line that names it and the mend") {
  CheckRefused(Program({"--no-such-flag"}), "--no-such-flag");
  CheckRefused(Program({"--cell-size-m", "5"}), "--cell-size-m: '5' is not a number from 0.005 to 1");
  CheckRefused(Program({"--cell-size-m", "small"}), "--cell-size-m: 'small' is not a number from 0.005 to 1");
  CheckRefused(Program({"--cell-size-m", "0.05m"}), "--cell-size-m: '0.05m' is not a number");
  CheckRefused(Program({"--cell-size-m"}), "--cell-size-m");
  CheckRefused(Program({"--seed", "-1"}), "--seed: '-1' is not a whole number from 0");
  CheckRefused(Program({"--algorithm", "best"}), "--algorithm: 'best' is not one of crsm, paper");
  CheckRefused(Program({"--preset", "pocket"}),
               "--preset: 'pocket' is not one of paper, rplidar-a1, sick, urg-04lx, utm-30lx");
  CheckRefused(Program({"--profile", "best"}), "--profile: 'best' is not one of default, paper");
}

TEST_CASE("what a laser says of itself holds where nobody has said otherwise, and is handed on") {
  Program silent({});
  silent.line.SetUnlessSaid("sweep_s", "0.075");
  CHECK(silent.parameters().scan.sweep_s == 0.075);
  CHECK(silent.line.WordsFor({{ParameterGroup::kLaser}, {}}) == std::vector<std::string>{"--sweep-s", "0.075"});
  Program flagged({"--sweep-s", "0.1"});
  flagged.line.SetUnlessSaid("sweep_s", "0.075");
  CHECK(flagged.parameters().scan.sweep_s == 0.1);
  Program preset({"--preset", "rplidar-a1"});
  preset.line.SetUnlessSaid("sweep_s", "0.075");
  CHECK(preset.parameters().scan.sweep_s == 0.15);
}

TEST_CASE("what the scans show goes before a preset, not before a flag") {
  Program preset({"--preset", "rplidar-a1", "--range-max-m", "9"});
  preset.line.Correct("sweep_s", "-0.1");
  preset.line.Correct("range_max_m", "8");
  CHECK(preset.parameters().scan.sweep_s == -0.1);
  CHECK(preset.parameters().scan.range_max_m == 9.0);
  CHECK(preset.line.WhoSaid("range_max_m") == "--range-max-m 9");
  CHECK(preset.line.WhoSaid("cell_size_m").find("rplidar-a1") != std::string::npos);
}

TEST_CASE("a sweep that is typed goes before the times in the messages, one of a preset does not") {
  CHECK_FALSE(Program({"--sweep-s", "0.1"}).parameters().scan.beam_times);
  CHECK(Program({"--sweep-s", "0.1", "--beam-times"}).parameters().scan.beam_times);
  CHECK(Program({"--preset", "rplidar-a1"}).parameters().scan.beam_times);
}

TEST_CASE("a start is three numbers, or none") {
  CHECK_FALSE(Program({}).parameters().match.start);
  CHECK_FALSE(Program({"--start", ""}).parameters().match.start);
  const Program program({"--start", "3.5,-2,1.5"});
  REQUIRE(program.parameters().match.start);
  CHECK(*program.parameters().match.start == Pose2{3.5, -2.0, 1.5});
  for (const std::string text : {"1,2", "1,2,3,4", "1,2,", ",,", "1,2,x", "1;2;3", "nan,0,0", "1e9,0,0", "0,0,inf"}) {
    CheckRefused(Program({"--start", text}), "--start: '" + text + "' is not X,Y,YAW [m, m, rad]");
  }
}

TEST_CASE("a flag of another program is unknown here") {
  CheckRefused(Program({"--rays-max", "50"}, {ParameterGroup::kScan}), "--rays-max");
}

TEST_CASE("a mistyped flag, name or key is answered with the nearest one") {
  CheckRefused(Program({"--preste", "sick"}), "--preste; did you mean --preset? --help lists the flags");
  CheckRefused(Program({"--preste=sick"}), "; did you mean --preset? ");
  CheckRefused(Program({"--no-lops"}), "; did you mean --no-loops? ");
  CheckRefused(Program({"--nonesuch"}), "--nonesuch; --help lists the flags");
  CheckRefused(Program({"--preset", "sik"}), "urg-04lx, utm-30lx; did you mean sick?");
  CheckRefused(Program({"--profile", "papr"}), "default, paper; did you mean paper?");
  for (const auto& [text, nearest] : std::map<std::string, std::string>{{"rays_mx = 90\n", "rays_max"},
                                                                        {"range-max-m = 20\n", "range_max_m"},
                                                                        {"lcm_ulr = \"\"\n", "lcm_url"},
                                                                        {"prset = \"sick\"\n", "preset"}}) {
    const ScratchFile file(text);
    CheckRefused(Program({"--config", file.path()}), "; did you mean " + nearest + "?");
  }
}

TEST_CASE("an option that takes some names alone suggests the nearest one") {
  CLI::App app("What it does.", "program");
  std::vector<std::string> chosen;
  TakeOneOf(*app.add_option("--without", chosen, "what is left out"), {"loop_closer", "map_exporter"});
  const auto ErrorOf = [&](const std::string& words) { return ParseErrorOf(app, words); };
  CHECK(ErrorOf("--without loop_closer").empty());
  CHECK(chosen == std::vector<std::string>{"loop_closer"});
  CHECK(ErrorOf("--without loop_closr") ==
        "--without: 'loop_closr' is not one of loop_closer, map_exporter; did you mean loop_closer? --help lists the "
        "flags");
}

TEST_CASE("a mistyped subcommand is answered with the nearest one, and its flags with theirs") {
  CLI::App app("What it does.", "program");
  app.require_subcommand(1);
  app.add_subcommand("summary", "what it prints")->add_flag("--csv");
  const auto ErrorOf = [&](const std::string& words) { return ParseErrorOf(app, words); };
  CHECK(ErrorOf("sumary").ends_with("; did you mean summary? --help lists the flags"));
  CHECK(ErrorOf("summary --cvs").ends_with("--cvs; did you mean --csv? --help lists the flags"));
}

TEST_CASE("help fits 100 columns, without a trailing space or two empty lines") {
  std::istringstream help(Program({"--help"}).said);
  std::string before = "none";
  for (std::string line; std::getline(help, line); before = line) {
    CAPTURE(line);
    CHECK(line.size() <= 100);
    CHECK_FALSE(line.ends_with(' '));
    CHECK_FALSE((line.empty() && before.empty()));
  }
  CHECK_FALSE(before.empty());
}

TEST_CASE("help begins with the flags that matter most, and ends with help itself") {
  const std::string help = Program({"--help"}).said;
  std::size_t last = 0;
  for (const char* text :
       {"What it does.", "Usage: program [OPTIONS]", "\nOptions:\n", "  --preset NAME", "  --odometry, --no-odometry",
        "\nEarlier runs:\n", "  --start X,Y,YAW", "\nLaser and odometry:\n", "  --range-max-m NUMBER",
        "\nMatching and map:\n", "  --profile NAME", "\nProcesses and bus:\n", "  --lcm-url URL",
        "\nHelp and configuration:\n", "  -h, --help", "  --config FILE"}) {
    CAPTURE(text);
    const std::size_t at = help.find(text);
    CHECK(at != std::string::npos);
    CHECK(at >= last);
    last = at;
  }
}

TEST_CASE("help lists the flags with their defaults, and the program ends well") {
  const Program help({"--help"});
  CHECK(help.exit_code == 0);
  for (const char* text : {"What it does.", "--cell-size-m", "--algorithm", "crsm|paper", "--lcm-url", "--preset"}) {
    CAPTURE(text);
    CHECK(help.Says(text));
  }
  CHECK_FALSE(help.Says("--export-period-s"));
  const Program version({"--version"});
  CHECK(version.exit_code == 0);
  CHECK(version.Says("program "));
}

}  // namespace crsm
