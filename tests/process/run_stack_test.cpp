// run_stack, by its script, on stand-ins of the programs, which write down what happens to them.

#include <algorithm>

#include "scratch.hpp"
#include "services/journal/journal.hpp"
#include "stand_ins.hpp"

namespace fs = std::filesystem;

namespace {

/// The rest of the event that begins so, which there must be.
std::string WhatBegins(const StandIns& stack, const std::string& beginning) {
  const std::string event = stack.Event(beginning);
  REQUIRE_FALSE(event.empty());
  return event.substr(beginning.size());
}

}  // namespace

TEST_CASE("run_stack starts the publisher last and ends the exporter before those that it asks") {
  StandIns stack;
  stack.Run("$run_stack sim:demo --out $out --seed 7");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(stack.Find("laser_publisher started sim:demo --rate max --position " +
                   stack.Path("out/log/laser_publisher.position") + " --seed 7") == 5);
  CHECK(stack.Find("map_updater started --lockstep") >= 0);
  CHECK(stack.Find("map_exporter started --out " + stack.Path("out")) >= 0);
  CHECK(stack.Find("laser_publisher finished") == 6);
  CHECK(stack.Find("map_exporter finished") == 7);
  for (const std::string service : {"map_updater", "loop_closer", "rrhc_matcher", "ray_selector"}) {
    CHECK(stack.Find(service + " finished") > 7);
  }
}

TEST_CASE(
    "in lockstep the processes that take turns share a core; at a pace, and beside them, each runs where it likes") {
  StandIns stack;
  const auto CoresOf = [&](const std::string& name) { return WhatBegins(stack, name + " may run on "); };
  stack.Run("taskset --cpu-list --pid $$ | sed 's/.*: //'");
  const std::string all = stack.output.substr(0, stack.output.find('\n'));
  stack.Run("$run_stack sim:demo --out $out", "CORES=1");
  const std::string shared = CoresOf("rrhc_matcher");
  CHECK(shared.find_first_not_of("0123456789") == std::string::npos);
  for (const char* name : {"laser_publisher", "ray_selector", "map_updater"}) CHECK(CoresOf(name) == shared);
  for (const char* name : {"loop_closer", "map_exporter"}) CHECK(CoresOf(name) == all);
  stack.Run("rm $EVENTS; $run_stack sim:demo --out $out --rate 2", "CORES=1");
  for (const char* name : {"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater"}) {
    CHECK(CoresOf(name) == all);
  }
}

TEST_CASE("at a pace the processes on a scan's way come before all others, and exporter and loop closer behind them") {
  StandIns stack;
  const auto ScheduleOf = [&](const std::string& name) { return WhatBegins(stack, name + " is scheduled by "); };
  stack.Run("cut -d ' ' -f 19 /proc/$$/stat | tr -d '\\n'");
  const std::string own_nice = stack.output;
  const std::string usual = "SCHED_OTHER " + own_nice;
  stack.Run("$run_stack sim:demo --out $out", "CORES=1");
  for (const char* name : {"laser_publisher", "rrhc_matcher", "map_exporter"}) CHECK(ScheduleOf(name) == usual);
  stack.Run("chrt --rr 5 true 2>/dev/null && echo may || nice -n -10 true 2>&1");
  const std::string first = stack.output.starts_with("may") ? "SCHED_RR|SCHED_RESET_ON_FORK " + own_nice
                            : stack.output.empty()          ? "SCHED_OTHER -10"
                                                            : usual;
  stack.Run("rm $EVENTS; $run_stack sim:demo --out $out --rate 2 --force", "CORES=1");
  for (const char* name : {"laser_publisher", "ray_selector", "rrhc_matcher", "map_updater"}) {
    CHECK(ScheduleOf(name) == first);
  }
  for (const char* name : {"loop_closer", "map_exporter"}) CHECK(ScheduleOf(name) == "SCHED_OTHER 10");
}

TEST_CASE(
    "run_stack starts what has died again, and after five deaths without a scan mapped shows its last words and ends") {
  for (const auto& [source, dying] : {std::pair("live", "rrhc_matcher"), std::pair("sim:demo", "laser_publisher")}) {
    StandIns stack;
    stack.Run(std::string("$run_stack ") + source + " --out $out", std::string("DYING=") + dying);
    INFO(stack.output);
    CHECK(stack.exit_code == 1);
    CHECK(stack.Said(dying + std::string(" ended unexpectedly (exit code 3): restarted")));
    CHECK(stack.Said(dying + std::string(" ended unexpectedly for the fifth time (exit code 3)")));
    CHECK(stack.Said(dying + std::string(": out of luck")));
    CHECK(stack.Find("map_exporter finished") >= 0);
    CHECK(stack.Find("map_updater finished") > stack.Find("map_exporter finished"));
  }
}

TEST_CASE("run_stack goes on without a viewer that dies five times") {
  StandIns stack;
  stack.Run("timeout --preserve-status --signal=INT 6 $run_stack live --out $out --view", "DYING=map_viewer");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(
      stack.Said("map_viewer ended unexpectedly for the fifth time (exit code 3), and no scan was mapped in between: "
                 "the mapping goes on without it\n"));
  CHECK(stack.Find("map_exporter finished") > stack.Find("map_viewer started"));
  stack.Run("timeout --preserve-status --signal=INT 2 $run_stack live --out $out --force --outputs mbot",
            "DYING=mbot_publisher");
  CHECK(stack.Said("mbot_publisher ended unexpectedly (exit code 3): restarted"));
}

TEST_CASE("run_stack starts a service again and again while scans are mapped") {
  StandIns stack;
  stack.Run("(" + AwaitEvent("map_updater") +
                "mkdir -p $out/journal; while sleep 0.1; do echo >>$out/journal/journal.lcm; done) & "
                "timeout --signal=INT 7 $run_stack live --out $out; kill $!",
            "DYING=rrhc_matcher");
  INFO(stack.output);
  CHECK_FALSE(stack.Said("fifth time"));
  std::size_t num_starts = 0;
  for (auto at = stack.output.find("restarted"); at != std::string::npos; at = stack.output.find("restarted", at + 1)) {
    ++num_starts;
  }
  CHECK(num_starts >= 6);
}

TEST_CASE("run_stack localises with a map_updater that has the earlier map, also when it is started again") {
  StandIns stack;
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
  StandIns stack;
  stack.Run("$run_stack sim:demo --out $out", "UNREADY=map_updater");
  INFO(stack.output);
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("map_updater was not ready within 10 s"));
  CHECK(stack.Find("laser_publisher started") == -1);
  CHECK(stack.Find("map_updater finished") >= 0);
}

TEST_CASE("an interrupted run_stack lets the exporter finish and succeeds") {
  StandIns stack;
  stack.Run("timeout --preserve-status --signal=INT 1 $run_stack live --out $out");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(stack.Find("map_exporter finished") == 5);
  CHECK(stack.Find("map_updater finished") > 5);
}

TEST_CASE("a second run_stack on the same port is refused, on another one it runs") {
  StandIns stack;
  stack.Run("$run_stack sim:demo --out $out & " + AwaitEvent("map_exporter") +
            "$run_stack sim:demo --out $out.2; code=$?; wait; exit $code");
  CHECK(stack.exit_code == 1);
  const std::string port = stack.url.substr(stack.url.rfind(':') + 1, 5);
  CHECK(stack.Said("port " + port + " already has its stack, process "));
  CHECK(stack.Said("run_stack sim:demo --out " + stack.Path("out") + "): stop that process, or choose another bus"));
  stack.Run(
      "$run_stack sim:demo --out $out & "
      "$run_stack sim:demo --out $out.2 --lcm-url $other_url; code=$?; wait; exit $code");
  CHECK(stack.exit_code == 0);
}

TEST_CASE("of stacks that start and end all the time on one port no two run at once, whoever comes first") {
  StandIns stack;
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
  StandIns stack;
  std::ofstream(stack.Path("out.toml")) << "preset = \"utm-30lx\"\nrate = \"2\"\nlockstep = true\nresume = true\n";
  stack.Run(
      "$run_stack sim:demo --out $out --config $out.toml --profile paper --seed 7 --no-odometry --range-max-m 9 "
      "--rays-max 70 --cell-size-m 0.1 --export-period-s 2 --resend-s 0.2 --map-wait-s 1 "
      "--part-bytes 1400 --channel-prefix robot1/ --laser-channel FRONT --view --http 127.0.0.1:8000");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  const std::string common = " --config " + stack.Path("out.toml") + " --profile paper";
  CHECK(stack.Event("laser_publisher") ==
        "laser_publisher started sim:demo --rate 2 --position " + stack.Path("out/log/laser_publisher.position") +
            common + " --channel-prefix robot1/ --laser-channel FRONT --no-odometry --resend-s 0.2 --seed 7");
  CHECK(stack.Event("ray_selector") == "ray_selector started --laser-channel LASER" + common +
                                           " --channel-prefix robot1/ --range-max-m 9 --rays-max 70");
  CHECK(stack.Event("rrhc_matcher") == "rrhc_matcher started --no-lockstep" + common +
                                           " --channel-prefix robot1/ --no-odometry --map-wait-s 1 --seed 7");
  CHECK(stack.Event("map_updater") ==
        "map_updater started --no-lockstep --journal " + stack.Path("out/journal") + common +
            " --channel-prefix robot1/ --part-bytes 1400 --range-max-m 9 --cell-size-m 0.1 --no-resume");
  CHECK(
      stack.Event("map_exporter") ==
      "map_exporter started --out " + stack.Path("out") +
          " --made-from sim:demo --profile paper --config out.toml --laser-channel FRONT --no-odometry --range-max-m 9 "
          "--rays-max 70 --seed 7 --cell-size-m 0.1" +
          common + " --channel-prefix robot1/ --export-period-s 2");
  CHECK(stack.Event("map_viewer") == "map_viewer started" + common + " --channel-prefix robot1/ --http 127.0.0.1:8000");
}

TEST_CASE("what is of the laser, the odometry or the pace is for who reads the log, or else for who hears the driver") {
  const std::string bag = CRSM_SOURCE_DIR "/tests/bags/data/run.db3";
  const std::string odom_bag = CRSM_SOURCE_DIR "/tests/bags/data/lz4.bag";
  struct Case {
    std::string words;
    std::map<std::string, std::string> started;  ///< with what: the end of it
  };
  for (const Case& one : std::vector<Case>{
           {"sim:demo --rate 2", {{"rrhc_matcher", " started"}}},
           {"live --laser-channel LIDAR --no-botlab-clockwise",
            {{"ray_selector", " started --laser-channel LIDAR --no-botlab-clockwise"}, {"rrhc_matcher", " started"}}},
           {"sim:demo --no-botlab-clockwise", {{"laser_publisher", " --no-botlab-clockwise"}}},
           {"live --laser-frame front", {{"ray_selector", " started --laser-frame front"}}},
           {bag + " --laser-frame laser",
            {{"laser_publisher", " --laser-frame laser"},
             {"ray_selector", " started --laser-channel LASER --laser-frame "}}},
           {"live --odometry-topic WHEELS", {{"rrhc_matcher", " started --odometry-topic WHEELS"}}},
           {odom_bag + " --config $out.toml",
            {{"rrhc_matcher", " started --lockstep --odometry-topic ODOMETRY --config $out.toml"}}},
           {odom_bag + " --odometry-topic /odom",
            {{"rrhc_matcher", " started --lockstep --odometry-topic ODOMETRY"},
             {"laser_publisher", " --odometry-topic /odom"}}},
           {"sim:demo --outputs mbot --channel-prefix robot1/",
            {{"mbot_publisher", " started --channel-prefix robot1/"}}}}) {
    StandIns stack;
    std::ofstream(stack.Path("out.toml")) << "odometry_topic = \"/odom\"\n";
    const std::string live = one.words.starts_with("live") ? "timeout --signal=INT 3 " : "";
    stack.Run(live + "$run_stack " + one.words + " --out $out");
    INFO(one.words << '\n' << stack.output);
    for (const auto& [process, started] : one.started) {
      std::string expected = started;
      if (const auto at = expected.find("$out"); at != std::string::npos) expected.replace(at, 4, stack.Path("out"));
      CHECK(stack.Event(process + " started").ends_with(expected));
    }
  }
}

TEST_CASE("run_stack --without leaves a process to somebody else, and says what that one has to do") {
  for (const std::string name : {"ray_selector", "rrhc_matcher", "loop_closer", "map_exporter"}) {
    CAPTURE(name);
    StandIns stack;
    stack.Run("$run_stack sim:demo --out $out --channel-prefix 'a b/' --without " + name);
    INFO(stack.output);
    CHECK(stack.exit_code == 0);
    CHECK(stack.Said("run_stack: without " + name + ": another process must "));
    CHECK(stack.Said("; ours would be started as: " + name + " "));
    CHECK(stack.Said(" --channel-prefix 'a b/'"));
    CHECK(stack.Find(name + " started") == -1);
    CHECK(stack.Find("map_updater finished") >= 0);
    CHECK(stack.Find("laser_publisher finished") == 5);
  }
  StandIns stack;
  stack.Run("$run_stack sim:demo --out $out --without ray_selector --without rrhc_matcher");
  CHECK(stack.Find("laser_publisher started") == 3);
}

TEST_CASE("run_stack counts neither lost scans nor those of other pieces as mapped while it runs") {
  StandIns stack;
  stack.Run("(" + AwaitEvent("map_exporter") +
            R"(echo '{"scans": 16, "on_map": 7, "floating": 3, "lost": 5, "without_rays": 1, "verdict": {}}' )" +
            R"(>$out/summary.json) & )" + "timeout --signal=INT 8 $run_stack live --out $out");
  INFO(stack.output);
  CHECK(stack.Said("run_stack: 7 scans mapped, 3 floating (on another piece), 5 lost, 1 without rays\n"));
}

TEST_CASE("run_stack --strict ends with the verdict on the map, and where there is none says so") {
  StandIns stack;
  const auto Run = [&](const std::string& summary, const std::string& flags) {
    stack.Run("$run_stack sim:demo --force --out $out " + flags, "SUMMARY='" + summary + "'");
  };
  const std::string good =
      R"({"ended": true, "scans": 7, "verdict": {"trust": "good", "lines": ["5 of 7 scans mapped"]}, )"
      R"("counts": {"lost": 9, "a.dropped_overload": 3, "b.dropped_overload": 4}})";
  Run(good, "");
  CHECK(stack.exit_code == 0);
  CHECK(stack.Said("5 of 7 scans mapped\n7 scans dropped: the machine is too slow\nsee " + stack.Path("out") + "\n"));
  Run(good, "--strict");
  CHECK(stack.exit_code == 0);
  Run(R"({"ended": true, "verdict": {"trust": "doubtful", "lines": []}})", "--strict");
  CHECK(stack.exit_code == 0);
  const std::string bad = R"({"ended": true, "verdict": {"trust": "bad", "lines": ["warning: doubled"]}})";
  Run(bad, "");
  CHECK(stack.exit_code == 0);
  CHECK(stack.Said("warning: doubled\n"));
  Run(bad, "--strict");
  CHECK(stack.exit_code == 3);
  Run(R"({"ended": true, "verdict": {"lines": 7}})", "--strict");
  CHECK(stack.exit_code == 3);
  Run(R"({"ended": false, "on_map": 7, "verdict": {"trust": "good", "lines": ["7 of 7 scans mapped"]}})", "");
  CHECK(stack.exit_code == 1);
  CHECK_FALSE(stack.Said("7 of 7 scans mapped"));
  CHECK(stack.Said(stack.Path("out/summary.json") + " is of scan 7, when the run had not ended"));
  Run(R"({"ended": true, "on_map": 7})", "--strict");
  CHECK(stack.exit_code == 1);
  CHECK(stack.Said("run_stack: --strict: " + stack.Path("out/summary.json") + " has no verdict on the map"));
}

TEST_CASE("run_stack gives no verdict where the results are of another map than the journal") {
  StandIns stack;
  const crsm::ScratchFolder folder;
  { crsm::Journal(folder.path(), {}, 0x2a).Append(nullptr, crsm::ScanMatch{1}); }
  for (const auto& [identity, exit_code] : {std::pair("000000000000002b", 1), std::pair("000000000000002a", 0)}) {
    const std::string summary = std::string(R"({"ended": true, "identity": ")") + identity +
                                R"(", "verdict": {"trust": "good", "lines": ["7 of 7 scans mapped"]}})";
    stack.Run("rm -rf $out; mkdir -p $out/journal; cp " + (folder / "journal.lcm").string() +
                  " $out/journal; $run_stack sim:demo --out $out --resume $out",
              "SUMMARY='" + summary + "'");
    INFO(stack.output);
    CHECK(stack.exit_code == exit_code);
    CHECK(stack.Said("7 of 7 scans mapped") == (exit_code == 0));
    CHECK(stack.Said("its summary.json is of another map than its journal") == (exit_code == 1));
  }
}

TEST_CASE("run_stack refuses what it does not know, in one line") {
  StandIns stack;
  stack.Run("touch $out; $run_stack sim:demo --out $out/below; rm $out");
  CHECK(stack.output == "run_stack: --out " + stack.Path("out/below") + ": cannot be written: Not a directory\n");
  const auto CheckRefused = [&](const std::string& words, const std::string& expected) {
    stack.Run("$run_stack " + words);
    INFO(words);
    CHECK(stack.exit_code == 2);
    CHECK(stack.output == "run_stack: " + expected + "\n");
  };
  CheckRefused("sim:demo --out $out --ratio 3",
               "The following argument was not expected: --ratio; did you mean --rate? --help lists the flags");
  CheckRefused("sim:demo", "--out is missing: give the folder for the results");
  CheckRefused("--out $out", "SOURCE is required; --help lists the flags");
  CheckRefused("sim:demo --out", "--out: DIR is missing; --help lists the flags");
  CheckRefused("sim:demo --out $out --rate 0", "--rate: '0' is neither max nor a number above 0");
  CheckRefused("live --out $out --rate 1", "--rate: applies to logs only; remove it for live scans");
  CheckRefused("sim:demo --out $out --strict --without map_exporter",
               "--strict: needs the verdict of map_exporter; remove --without map_exporter");
  CheckRefused("sim:demo --out $out --start 1,2,3",
               "--start: needs a finished map: add --localize DIR, or a map to continue: --resume DIR");
  CheckRefused("sim:demo --out $out --resume $out --force",
               "--resume extends a map and --force begins a new one: give only one of them");
  for (const std::string wrong : {"--without map_updater", "--outputs ros"}) {
    stack.Run("$run_stack sim:demo --out $out " + wrong);
    CHECK(stack.exit_code == 2);
    CHECK(stack.Said("run_stack: " + wrong.substr(0, wrong.find(' ')) + ": "));
  }
  stack.Run("$run_stack sim:demo --out $out --lcm-url udp://239.255.76.67:7667");
  CHECK(stack.exit_code == 2);
  CHECK(stack.Said("--lcm-url udp://239.255.76.67:7667: is no bus between processes"));
  CHECK(stack.Find("") == -1);
  CHECK_FALSE(fs::exists(stack.Path("out")));
}
