// run_stack, by its script, on stand-ins of the five programs, which write down what happens to them.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "catch.hpp"

namespace {

namespace fs = std::filesystem;

// Takes 0.5 s over its work if it is the publisher, else waits for SIGINT; the exporter then takes 0.3 s to finish.
constexpr const char* kStandIn = R"(#!/usr/bin/env bash
name=$(basename "$0")
say() { echo "$name $*" >>"$EVENTS"; }
finish() { [[ $name != map_exporter ]] || sleep 0.3; say finished; exit 0; }
trap finish INT TERM
say started "$@"
[[ $UNREADY == "$name" ]] || echo "$name: ready" >&2
[[ $DYING != "$name" ]] || { sleep 0.5; echo "$name: out of luck" >&2; exit 3; }
[[ $name != laser_publisher ]] || { sleep 0.5; finish; }
while :; do sleep 0.05; done
)";

/// The shell's words for: wait until a process has said something.
std::string AwaitEvent(const std::string& name) { return "until grep -qs " + name + " $EVENTS; do sleep 0.05; done; "; }

/// A folder with the stand-ins, a bus of its own, and what became of the last run.
class Stack {
 public:
  Stack() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    for (const char* name : {"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater", "map_exporter"}) {
      std::ofstream(folder_ / name) << kStandIn;
      fs::permissions(folder_ / name, fs::perms::owner_all);
    }
    fs::create_symlink(CRSM_BIN_DIR "/run_stack", folder_ / "run_stack");
  }
  ~Stack() { fs::remove_all(folder_); }

  /// Runs a shell command in which $run_stack stands for the script, and keeps what it said.
  void Run(const std::string& command, const std::string& environment = "") {
    const std::string all = "export CRSM_BIN_DIR=" + folder_.string() + " EVENTS=" + Path("events") +
                            " UNREADY= DYING= LCM_DEFAULT_URL='udpm://239.255.76.67:7797?ttl=0' " + environment +
                            "; run_stack=" + CRSM_SOURCE_DIR + "/scripts/run_stack; out=" + Path("out") +
                            "; exec 2>&1; " + command;
    FILE* pipe = popen(all.c_str(), "r");
    REQUIRE(pipe);
    output.clear();
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) output += static_cast<char>(c);
    const int status = pclose(pipe);
    exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// The line number of an event, counted from 0, or -1.
  int Find(const std::string& event) const {
    std::ifstream file(folder_ / "events");
    std::string line;
    for (int number = 0; std::getline(file, line); ++number) {
      if (line.rfind(event, 0) == 0) return number;
    }
    return -1;
  }

  /// The whole text of the first event that begins so; empty if there is none.
  std::string Event(const std::string& beginning) const {
    std::ifstream file(folder_ / "events");
    for (std::string line; std::getline(file, line);) {
      if (line.rfind(beginning, 0) == 0) return line;
    }
    return "";
  }

  bool Said(const std::string& text) const { return output.find(text) != std::string::npos; }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  std::string output;
  int exit_code = -1;

 private:
  fs::path folder_ = fs::temp_directory_path() / ("crsm_run_stack_test_" + std::to_string(getpid()));
};

}  // namespace

TEST_CASE("run_stack starts the publisher last and ends the exporter before those that it asks") {
  Stack stack;
  stack.Run("$run_stack sim:demo --out $out --seed 7");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(stack.Find("laser_publisher started sim:demo --rate max --position " +
                   stack.Path("out/log/laser_publisher.position") + " --seed 7") == 4);
  CHECK(stack.Find("map_updater started --lockstep") >= 0);
  CHECK(stack.Find("map_exporter started --out " + stack.Path("out")) >= 0);
  CHECK(stack.Find("laser_publisher finished") == 5);
  CHECK(stack.Find("map_exporter finished") == 6);
  CHECK(stack.Find("map_updater finished") > 6);
  CHECK(stack.Find("rrhc_matcher finished") > 6);
  CHECK(stack.Find("ray_selector finished") > 6);
}

TEST_CASE("run_stack without lockstep keeps the pace that was asked for") {
  Stack stack;
  stack.Run("$run_stack sim:demo --out $out --rate 2");
  CHECK(stack.exit_code == 0);
  CHECK(stack.Find("laser_publisher started sim:demo --rate 2") == 4);
  CHECK(stack.Find("rrhc_matcher started --lockstep") == -1);
}

TEST_CASE(
    "run_stack starts a dead service again, and after five deaths without a scan mapped shows its last words and ends "
    "the others") {
  Stack stack;
  stack.Run("$run_stack live --out $out", "DYING=rrhc_matcher");
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("rrhc_matcher ended in the middle of the work (exit code 3): started again"));
  CHECK(stack.Said("rrhc_matcher ended in the middle of the work for the fifth time (exit code 3)"));
  CHECK(stack.Said("rrhc_matcher: out of luck"));
  CHECK(stack.Find("map_exporter finished") >= 0);
  CHECK(stack.Find("map_updater finished") > stack.Find("map_exporter finished"));
}

TEST_CASE("run_stack starts a service again and again while scans are mapped") {
  Stack stack;
  stack.Run("(" + AwaitEvent("map_updater") +
                "mkdir -p $out/journal; while sleep 0.1; do echo >>$out/journal/journal.lcm; done) & "
                "timeout --signal=INT 7 $run_stack live --out $out; kill $!",
            "DYING=rrhc_matcher");
  INFO(stack.output);
  CHECK_FALSE(stack.Said("fifth time"));
  std::size_t num_starts = 0;
  for (auto at = stack.output.find("started again"); at != std::string::npos;
       at = stack.output.find("started again", at + 1)) {
    ++num_starts;
  }
  CHECK(num_starts >= 6);
}

TEST_CASE("run_stack goes on with an earlier run where it is told to, whose journal it then has") {
  Stack stack;
  const std::string make_earlier =
      "mkdir -p $out/journal $out.1/journal; echo old >$out/journal/journal.lcm; echo 1 >$out.1/journal/journal.lcm; ";
  stack.Run(make_earlier + "$run_stack sim:demo --out $out.2 --resume $out.1; cat $out.2/journal/* $out.1/journal/*");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(stack.output.substr(stack.output.size() - 4) == "1\n1\n");
  const std::string updater = "map_updater started --lockstep --journal ";
  CHECK(stack.Event(updater) == updater + stack.Path("out.2/journal") + " --resume");
  stack.Run(make_earlier + "$run_stack sim:demo --out $out --resume $out; cat $out/journal/*");
  CHECK(stack.output.substr(stack.output.size() - 4) == "old\n");
}

TEST_CASE("run_stack localises with a map_updater that has the earlier map, also when it is started again") {
  Stack stack;
  stack.Run("mkdir -p $out.1/journal; echo 1 >$out.1/journal/journal.lcm; (" + AwaitEvent("map_updater") +
                "mkdir $out/journal; echo 2 >$out/journal/journal.lcm) & "
                "timeout --preserve-status --signal=INT 3 $run_stack live --out $out --localize $out.1 --start 1,2,3",
            "DYING=map_updater");
  INFO(stack.output);
  const std::string command =
      "map_updater started --journal " + stack.Path("out/journal") + " --localize " + stack.Path("out.1");
  CHECK(stack.Event(command) == command);
  CHECK(stack.Find(command + " --resume") > 0);
  CHECK(stack.Find("rrhc_matcher started --start 1,2,3") >= 0);
  stack.Run("rm -r $out.1; $run_stack live --out $out --localize $out.1 2>&1");
  CHECK(stack.output == "run_stack: there is no file " + stack.Path("out.1") + "/journal/journal.lcm\n");
}

TEST_CASE("run_stack names a service that does not get ready") {
  Stack stack;
  stack.Run("$run_stack sim:demo --out $out", "UNREADY=map_updater");
  INFO(stack.output);
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("map_updater was not ready within 10 s"));
  CHECK(stack.Find("laser_publisher started") == -1);
  CHECK(stack.Find("map_updater finished") >= 0);
}

TEST_CASE("run_stack starts a dead publisher again as it was, and gives up one that always dies") {
  Stack stack;
  stack.Run("$run_stack sim:demo --out $out", "DYING=laser_publisher");
  INFO(stack.output);
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("laser_publisher ended in the middle of the work (exit code 3): started again"));
  CHECK(stack.Said("laser_publisher ended in the middle of the work for the fifth time (exit code 3)"));
  CHECK(stack.Find("map_exporter finished") >= 0);
}

TEST_CASE("an interrupted run_stack lets the exporter finish and succeeds") {
  Stack stack;
  stack.Run("timeout --preserve-status --signal=INT 1 $run_stack live --out $out");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(stack.Find("map_exporter finished") == 4);
  CHECK(stack.Find("map_updater finished") > 4);
}

TEST_CASE("a second run_stack on the same port is refused, on another one it runs") {
  Stack stack;
  stack.Run("$run_stack sim:demo --out $out & " + AwaitEvent("map_exporter") +
            "$run_stack sim:demo --out $out.2; code=$?; wait; exit $code");
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("port 7797 has its stack already, process "));
  CHECK(stack.Said("run_stack sim:demo --out " + stack.Path("out") + "): end that one, or choose another bus"));
  stack.Run(
      "$run_stack sim:demo --out $out & "
      "$run_stack sim:demo --out $out.2 --lcm-url 'udpm://239.255.76.67:7798?ttl=0'; code=$?; wait; exit $code");
  CHECK(stack.exit_code == 0);
}

TEST_CASE("of stacks that start and end all the time on one port no two run at once, whoever comes first") {
  Stack stack;
  const std::string twice =
      "(n=0; for j in $(seq 3000); do [ $n = 2 ] || { $run_stack sim:demo --out $out.$i && n=$((n + 1)); }; done)";
  stack.Run("for i in 1 2 3; do " + twice + " & done; wait");
  std::ifstream events(stack.Path("events"));
  int num_updaters = 0;
  int num_stacks = 0;
  int most_updaters = 0;
  for (std::string line; std::getline(events, line);) {
    if (line.rfind("map_updater started", 0) == 0) ++num_stacks, ++num_updaters;
    if (line == "map_updater finished") --num_updaters;
    most_updaters = std::max(most_updaters, num_updaters);
  }
  CHECK(num_stacks == 6);
  CHECK(most_updaters == 1);
}

TEST_CASE("run_stack hands each process the flags that belong to it") {
  Stack stack;
  std::ofstream(stack.Path("config.toml")) << "preset = \"urg-04lx\"\nrate = \"2\"\nlockstep = true\nresume = true\n";
  stack.Run(
      "$run_stack sim:demo --out $out --config $out/../config.toml --profile paper --seed 7 --odometry --range-max-m 9 "
      "--no-limit-edges --cell-size-m 0.1 --num-evaluations 50 --export-period-s 2 --resend-s 0.2 --map-wait-s 1 "
      "--part-bytes 1400 --channel-prefix robot1/ --laser-channel FRONT");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  const std::string common = " --config " + stack.Path("out/../config.toml") + " --profile paper";
  CHECK(stack.Event("laser_publisher") == "laser_publisher started sim:demo --rate 2 --position " +
                                              stack.Path("out/log/laser_publisher.position") + common +
                                              " --seed 7 --odometry --resend-s 0.2 --channel-prefix robot1/"
                                              " --laser-channel FRONT");
  CHECK(stack.Event("ray_selector") ==
        "ray_selector started" + common + " --range-max-m 9 --no-limit-edges --channel-prefix robot1/");
  CHECK(stack.Event("rrhc_matcher") == "rrhc_matcher started --no-lockstep" + common +
                                           " --seed 7 --odometry --num-evaluations 50 --map-wait-s 1"
                                           " --channel-prefix robot1/");
  CHECK(stack.Event("map_updater") == "map_updater started --no-lockstep --journal " + stack.Path("out/journal") +
                                          common +
                                          " --cell-size-m 0.1 --part-bytes 1400 --channel-prefix robot1/"
                                          " --no-resume");
  CHECK(stack.Event("map_exporter") == "map_exporter started --out " + stack.Path("out") + common +
                                           " --seed 7 --export-period-s 2 --channel-prefix robot1/");
}

TEST_CASE("run_stack leaves the results of an earlier run as they are, and says the three ways out") {
  Stack stack;
  const std::string list = "cd $out; find . -type f | sort | xargs md5sum; cd - >/dev/null; ";
  for (const std::string file : {"map.png", "trajectory.tum", "journal/journal.lcm"}) {
    stack.Run("rm -rf $out; mkdir -p $out/journal $out/log; echo 1 >$out/" + file + "; echo 2 >$out/summary.json; " +
              list);
    const std::string before = stack.output;
    for (const std::string source : {"sim:demo", "live"}) {
      stack.Run("$run_stack " + source + " --out $out; code=$?; exec 3>&1; exit $code");
      INFO(file << ' ' << stack.output);
      CHECK(stack.exit_code == 1);
      CHECK(stack.output == "run_stack: --out " + stack.Path("out") +
                                ": holds the results of an earlier run: --resume " + stack.Path("out") +
                                " goes on with its map, --force moves them to " + stack.Path("out/earlier.1") +
                                ", or choose another folder\n");
    }
    stack.Run("$run_stack nonesuch.log --out $out --force");
    CHECK(stack.output == "run_stack: there is no file nonesuch.log\n");
    stack.Run(list);
    CHECK(stack.output == before);
  }
  CHECK(stack.Find("") == -1);
}

TEST_CASE("run_stack --force moves the results of an earlier run aside, and nothing else") {
  Stack stack;
  stack.Run(
      "mkdir -p $out/journal $out/log; for f in map.png summary.json journal/journal.lcm log/map_updater.log my.lcm; "
      "do "
      "echo $f >$out/$f; done; $run_stack sim:demo --out $out --force && ls $out/earlier.1/* && cat $out/my.lcm && "
      "ls $out/journal");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(stack.Said("run_stack: the earlier results in " + stack.Path("out") + " are now in " +
                   stack.Path("out/earlier.1")));
  for (const char* file : {"map.png", "summary.json", "journal/journal.lcm", "log/map_updater.log"}) {
    CHECK(fs::exists(stack.Path("out/earlier.1/") + file));
  }
  CHECK(fs::exists(stack.Path("out/my.lcm")));
  CHECK_FALSE(fs::exists(stack.Path("out/map.png")));
  CHECK_FALSE(fs::exists(stack.Path("out/journal/journal.lcm")));
  stack.Run("echo 2 >$out/map.png; $run_stack sim:demo --out $out --force && cat $out/earlier.2/map.png");
  CHECK(stack.exit_code == 0);
}

TEST_CASE("run_stack takes a folder in which a run saw no scan for an empty one") {
  Stack stack;
  stack.Run(
      "mkdir -p $out/journal; echo 1 >$out/map.png; touch $out/trajectory.tum $out/journal/journal.lcm; "
      "$run_stack sim:demo --out $out");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
}

TEST_CASE("run_stack --strict ends with the verdict on the map, and where there is none says so") {
  Stack stack;
  const std::string json =
      R"({\"scans\": 7, \"lost\": 2, \"counts\": {\"a.dropped_overload\": 3, \"b.dropped_overload\": 4}})";
  const std::string trusted = R"({\"trusted\": true})";
  const std::string untrusted = R"({\"trusted\": false})";
  const auto Run = [&](const std::string& summary, const std::string& flags) {
    stack.Run("(sleep 0.7; echo \"" + summary + "\" >$out/summary.json) & $run_stack sim:demo --out $out " + flags);
  };
  Run(json, "");
  CHECK(stack.exit_code == 0);
  CHECK(stack.output == "7 scans mapped, 2 lost, 7 dropped; see " + stack.Path("out") + "\n");
  Run(json, "--strict");
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("run_stack: --strict: " + stack.Path("out/summary.json") + " has no verdict on the map"));
  Run(trusted, "--strict");
  CHECK(stack.exit_code == 0);
  Run(untrusted, "--strict");
  CHECK(stack.exit_code == 3);
  Run(untrusted, "");
  CHECK(stack.exit_code == 0);
}

TEST_CASE("run_stack whose folder is removed says so in one line and ends") {
  Stack stack;
  stack.Run("(" + AwaitEvent("map_exporter") + "sleep 2; rm -r $out) & timeout 30 $run_stack live --out $out");
  CHECK(stack.exit_code == 1);
  CHECK(stack.output == "run_stack: listening; Ctrl-C ends\nrun_stack: --out " + stack.Path("out") +
                            ": was removed or moved during the run, or its journal was: ends here\n");
  CHECK(stack.Find("map_updater finished") > stack.Find("map_exporter finished"));
}

TEST_CASE("run_stack does not wait for what is in the place of its files") {
  Stack stack;
  stack.Run("mkdir $out; mkfifo $out/log; timeout 5 $run_stack live --out $out");
  CHECK(stack.output == "run_stack: --out " + stack.Path("out/log") + ": is neither a folder nor a file\n");
}

TEST_CASE("a second stack in the folder of one that runs is refused, on whatever bus") {
  Stack stack;
  stack.Run(
      "$run_stack live --out $out & sleep 1; "
      "$run_stack live --out $out --lcm-url 'udpm://239.255.76.67:7798?ttl=0'; kill -INT $!; wait");
  INFO(stack.output);
  CHECK(stack.Said("run_stack: --out " + stack.Path("out/log") + ": process "));
  CHECK(stack.Said(") writes there"));
}

TEST_CASE("run_stack refuses what it does not know, in one line") {
  Stack stack;
  stack.Run("touch $out; $run_stack sim:demo --out $out/below; rm $out");
  CHECK(stack.output == "run_stack: --out " + stack.Path("out/below") + ": cannot be written: Not a directory\n");
  const auto CheckRefused = [&](const std::string& words, const std::string& expected) {
    stack.Run("$run_stack " + words);
    INFO(words);
    CHECK(stack.exit_code == 2);
    CHECK(stack.output == "run_stack: " + expected + "\n");
  };
  CheckRefused("sim:demo --out $out --ratio 3",
               "The following arguments were not expected: 3 --ratio; --help lists the flags");
  CheckRefused("sim:demo", "--out is missing: the folder for the results");
  CheckRefused("--out $out", "SOURCE is required; --help lists the flags");
  CheckRefused("sim:demo --out", "--out: 1 required TEXT missing; --help lists the flags");
  CheckRefused("sim:demo --out $out --preset sikc", "--preset: 'sikc' is not one of paper, sick, urg-04lx, utm-30lx");
  CheckRefused("sim:demo --out $out --rate 0", "--rate: '0' is neither max nor a number above 0");
  CheckRefused("live --out $out --rate 1", "--rate: is of a log; what is live comes at its own pace, on LASER");
  CheckRefused("sim:demo --out $out --start 1,2,3",
               "--start: is of a laser on a finished map: say which by --localize DIR");
  CheckRefused("sim:demo --out $out --intensity-min 0.5 --intensity-max 0.1",
               "intensity_min: 0.5 is more than intensity_max, 0.1");
  CheckRefused("sim:demo --out $out --resume $out --force",
               "--resume goes on with a map and --force begins a new one: one of them, please");
  stack.Run("$run_stack sim:demo --out $out --lcm-url udp://239.255.76.67:7667");
  CHECK(stack.exit_code == 2);
  CHECK(stack.Said("--lcm-url udp://239.255.76.67:7667: not a bus between processes"));
  CHECK(stack.Find("") == -1);
  CHECK_FALSE(fs::exists(stack.Path("out")));
}
