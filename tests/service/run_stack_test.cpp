// scripts/run_stack on stand-ins of the five programs, which write down what happens to them.

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
  }
  ~Stack() { fs::remove_all(folder_); }

  /// Runs a shell command in which $run_stack stands for the script, and keeps what it said.
  void Run(const std::string& command, const std::string& environment = "") {
    const std::string all =
        "export CRSM_BIN_DIR=" + folder_.string() + " TMPDIR=" + folder_.string() + " EVENTS=" + Path("events") +
        " UNREADY= DYING= LCM_DEFAULT_URL='udpm://239.255.76.67:7797?ttl=0' " + environment +
        "; run_stack=" + CRSM_SOURCE_DIR + "/scripts/run_stack; out=" + Path("out") + "; exec 2>&1; " + command;
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
  stack.Run("$run_stack some.log --out $out --seed 7");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(stack.Find("laser_publisher started some.log --rate max --seed 7") == 4);
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
  stack.Run(
      "mkdir -p $out/journal; (while sleep 0.1; do echo >>$out/journal/journal.lcm; done) & "
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

TEST_CASE("run_stack begins anew, unless it is told to go on with an earlier run, whose journal it then has") {
  Stack stack;
  const std::string make_earlier =
      "mkdir -p $out/journal $out.1/journal; echo old >$out/journal/journal.lcm; echo 1 >$out.1/journal/journal.lcm; ";
  stack.Run(make_earlier + "$run_stack some.log --out $out; cat $out/journal/journal.lcm");
  CHECK(stack.Said("No such file"));
  CHECK(stack.Find("map_updater started --lockstep --journal " + stack.Path("out/journal")) >= 0);
  stack.Run("rm $EVENTS; " + make_earlier +
            "$run_stack some.log --out $out --resume $out.1; cat $out/journal/* $out.1/journal/*");
  CHECK(stack.exit_code == 0);
  CHECK(stack.output.substr(stack.output.size() - 4) == "1\n1\n");
  CHECK(stack.Find("map_updater started --lockstep --journal " + stack.Path("out/journal") + " --resume") >= 0);
  stack.Run(make_earlier + "$run_stack some.log --out $out --resume $out; cat $out/journal/*");
  CHECK(stack.output.substr(stack.output.size() - 4) == "old\n");
}

TEST_CASE("run_stack localises with a map_updater that has the earlier map, also when it is started again") {
  Stack stack;
  stack.Run(
      "mkdir -p $out.1/journal $out/journal; echo 1 >$out.1/journal/journal.lcm; "
      "(sleep 0.4; echo 2 >$out/journal/journal.lcm) & "
      "timeout --preserve-status --signal=INT 3 $run_stack live --out $out --localize $out.1 --start 1,2,3",
      "DYING=map_updater");
  INFO(stack.output);
  const std::string command =
      "map_updater started --localize " + stack.Path("out.1") + " --journal " + stack.Path("out/journal");
  CHECK(stack.Find(command) >= 0);
  CHECK(stack.Find(command + " --resume") > 0);
  CHECK(stack.Find("rrhc_matcher started --start 1,2,3") >= 0);
  stack.Run("rm -r $out.1; $run_stack live --out $out --localize $out.1");
  CHECK(stack.output == "run_stack: there is no file " + stack.Path("out.1") + "/journal/journal.lcm\n");
}

TEST_CASE("run_stack names a service that does not get ready") {
  Stack stack;
  stack.Run("$run_stack some.log --out $out", "UNREADY=map_updater");
  INFO(stack.output);
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("map_updater was not ready within 10 s"));
  CHECK(stack.Find("laser_publisher started") == -1);
  CHECK(stack.Find("map_updater finished") >= 0);
}

TEST_CASE("run_stack says which process failed when the publisher cannot go on") {
  Stack stack;
  stack.Run("$run_stack some.log --out $out", "DYING=laser_publisher");
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("laser_publisher failed (exit code 3)"));
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
  stack.Run("$run_stack some.log --out $out & sleep 0.3; $run_stack some.log --out $out.2; code=$?; wait; exit $code");
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("another stack runs on port 7797"));
  stack.Run(
      "$run_stack some.log --out $out & "
      "$run_stack some.log --out $out.2 --lcm-url 'udpm://239.255.76.67:7798?ttl=0'; code=$?; wait; exit $code");
  CHECK(stack.exit_code == 0);
}

TEST_CASE("of stacks that start and end all the time on one port no two run at once, and no lock is left") {
  Stack stack;
  const std::string twice =
      "(n=0; for j in $(seq 3000); do [ $n = 2 ] || { $run_stack some.log --out $out.$i && n=$((n + 1)); }; done)";
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
  for (const auto& entry : fs::directory_iterator(stack.Path(""))) CHECK(entry.path().extension() != ".lock");
}

TEST_CASE("run_stack refuses what it does not know, in one line") {
  Stack stack;
  stack.Run("touch $out; $run_stack some.log --out $out/below; rm $out");
  CHECK(stack.output == "run_stack: --out " + stack.Path("out/below") + ": cannot be written: Not a directory\n");
  stack.Run("$run_stack some.log --out $out --ratio 3");
  CHECK(stack.exit_code == 1);
  CHECK(stack.output == "run_stack: unknown flag '--ratio', see --help\n");
  stack.Run("$run_stack some.log");
  CHECK(stack.output == "run_stack: needs a source and --out DIR, see --help\n");
  stack.Run("$run_stack some.log --out");
  CHECK(stack.output == "run_stack: --out needs a value\n");
  stack.Run("$run_stack one.log two.log --out $out");
  CHECK(stack.output == "run_stack: one source, please: 'one.log' or 'two.log'\n");
  CHECK(stack.Find("") == -1);
}
