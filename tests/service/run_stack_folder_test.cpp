// What run_stack does with the folder of its results, and with what is in it already; on stand-ins of the programs.

#include "stand_ins.hpp"

namespace fs = std::filesystem;

TEST_CASE("run_stack goes on with an earlier run where it is told to, whose journal it then has") {
  StandIns stack;
  const std::string make_earlier =
      "mkdir -p $out/journal $out.1/journal; echo old >$out/journal/journal.lcm; echo 1 >$out.1/journal/journal.lcm; ";
  stack.Run(make_earlier + "$run_stack sim:demo --out $out.2 --resume $out.1; cat $out.2/journal/* $out.1/journal/*");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
  CHECK(stack.output.substr(stack.output.size() - 4) == "1\n1\n");
  const std::string updater = "map_updater started --lockstep --journal ";
  CHECK(stack.Event(updater) == updater + stack.Path("out.2/journal") + " --resume --new-session");
  stack.Run(make_earlier + "$run_stack sim:demo --out $out --resume $out; cat $out/journal/*");
  CHECK(stack.output.substr(stack.output.size() - 4) == "old\n");
}

TEST_CASE("run_stack leaves the results of an earlier run as they are, and says the three ways out") {
  StandIns stack;
  const std::string list = "cd $out; find . -type f | sort | xargs md5sum; cd - >/dev/null; ";
  for (const std::string file : {"map.png", "trajectory.tum", "journal/journal.lcm"}) {
    stack.Run("rm -rf $out; mkdir -p $out/journal $out/log; echo 1 >$out/" + file + "; echo 2 >$out/summary.json; " +
              list);
    const std::string before = stack.output;
    for (const std::string source : {"sim:demo", "live"}) {
      stack.Run("timeout 20 $run_stack " + source + " --out $out");
      INFO(file << ' ' << stack.output);
      CHECK(stack.exit_code == 1);
      CHECK(stack.output == "run_stack: --out " + stack.Path("out") +
                                ": holds the results of an earlier run: --resume " + stack.Path("out") +
                                " continues its map, --force moves them to " + stack.Path("out/earlier.1") +
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
  StandIns stack;
  stack.Run(
      "mkdir -p $out/journal $out/log; for f in map.png summary.json journal/journal.lcm log/map_updater.log my.lcm; "
      "do echo $f >$out/$f; done; $run_stack sim:demo --out $out --force");
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
  StandIns stack;
  stack.Run(
      "mkdir -p $out/journal; echo 1 >$out/map.png; touch $out/trajectory.tum $out/journal/journal.lcm; "
      "$run_stack sim:demo --out $out");
  INFO(stack.output);
  CHECK(stack.exit_code == 0);
}

TEST_CASE("run_stack whose folder is removed says so in one line and ends") {
  StandIns stack;
  stack.Run("(" + AwaitEvent("map_exporter") + "sleep 2; rm -r $out) & timeout 30 $run_stack live --out $out");
  CHECK(stack.exit_code == 1);
  CHECK(stack.output == "run_stack: listening; Ctrl-C ends\nrun_stack: --out " + stack.Path("out") +
                            ": this folder or its journal was removed or moved: the run ends\n");
  CHECK(stack.Find("map_updater finished") > stack.Find("map_exporter finished"));
}

TEST_CASE("run_stack does not wait for what is in the place of its files") {
  StandIns stack;
  stack.Run("mkdir $out; mkfifo $out/log; timeout 5 $run_stack live --out $out");
  CHECK(stack.output == "run_stack: --out " + stack.Path("out/log") + ": is neither a folder nor a file\n");
}

TEST_CASE("a second stack in the folder of one that runs is refused, on whatever bus") {
  StandIns stack;
  stack.Run(
      "$run_stack live --out $out & sleep 1; "
      "$run_stack live --out $out --lcm-url $other_url; kill -INT $!; wait");
  INFO(stack.output);
  CHECK(stack.Said("run_stack: --out " + stack.Path("out/log") + ": process "));
  CHECK(stack.Said(") writes there"));
}
