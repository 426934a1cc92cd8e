#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "catch.hpp"
#include "processes.hpp"

// Takes 0.5 s over its work if it is the publisher, else waits for SIGINT; the exporter then takes 0.3 s to finish,
// and writes what SUMMARY says. With CORES, says which cores of the processor it may run on, and before whom.
inline constexpr const char* kStandIn = R"(#!/usr/bin/env bash
name=$(basename "$0")
say() { echo "$name $*" >>"$EVENTS"; }
folder=$2
finish() {
  [[ $name != map_exporter ]] || { sleep 0.3; [[ -z $SUMMARY ]] || echo "$SUMMARY" >"$folder/summary.json"; }
  say finished
  exit 0
}
trap finish INT TERM
say started "$@"
[[ -z $CORES ]] || say may run on $(taskset --cpu-list --pid $$ | sed 's/.*: //')
[[ -z $CORES ]] || say is scheduled by $(chrt --pid $$ | sed -n 's/.*policy: //p') $(cut -d ' ' -f 19 /proc/$$/stat)
[[ $UNREADY == "$name" ]] || echo "$name: ready" >&2
[[ $DYING != "$name" ]] || { sleep 0.5; echo "$name: out of luck" >&2; exit 3; }
[[ $name != laser_publisher ]] || { sleep 0.5; finish; }
while :; do sleep 0.05; done
)";

/// The shell's words for: wait until a process has said something.
inline std::string AwaitEvent(const std::string& name) {
  return "until grep -qs " + name + " $EVENTS; do sleep 0.05; done; ";
}

/// A folder with the stand-ins, a bus of its own, and what became of the last run.
class StandIns {
 public:
  StandIns() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    for (const char* name : {"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater", "loop_closer",
                             "map_exporter", "map_viewer", "mbot_publisher"}) {
      std::ofstream(folder_ / name) << kStandIn;
      std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
    }
    std::filesystem::create_symlink(CRSM_BIN_DIR "/run_stack", folder_ / "run_stack");
  }
  ~StandIns() { std::filesystem::remove_all(folder_); }

  /// Runs a shell command in which $run_stack stands for the script, $out for where results are to go, and $other_url
  /// for another bus than `url`. Keeps what it said.
  void Run(const std::string& command, const std::string& environment = "") {
    const std::string all = "export CRSM_BIN_DIR=" + folder_.string() + " EVENTS=" + Path("events") +
                            " UNREADY= DYING= SUMMARY= CORES= LCM_DEFAULT_URL='" + url + "' other_url='" +
                            crsm::MakeBusUrl() + "' " + environment + "; run_stack=" + CRSM_SOURCE_DIR +
                            "/scripts/run_stack; out=" + Path("out") + "; exec 2>&1; " + command;
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

  const std::string url = crsm::MakeBusUrl();
  std::string output;
  int exit_code = -1;

 private:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("crsm_run_stack_test_" + std::to_string(getpid()));
};
