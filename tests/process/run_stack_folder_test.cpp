// What run_stack does with the folder of its results; on stand-ins of the programs. earlier_results_test.cpp has more.

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

TEST_CASE("run_stack whose folder is removed says so in one line and ends") {
  StandIns stack;
  stack.Run("(" + AwaitEvent("map_exporter") + "sleep 2; rm -r $out) & timeout 30 $run_stack live --out $out");
  CHECK(stack.exit_code == 1);
  CHECK(stack.output == "run_stack: listening; Ctrl-C ends\nrun_stack: --out " + stack.Path("out") +
                            ": this folder or its journal was removed, moved or replaced: the run ends\n");
  CHECK(stack.Find("map_updater finished") > stack.Find("map_exporter finished"));
}

TEST_CASE("run_stack says once when nothing can be written to its folder any more, and when it can again") {
  StandIns stack;
  stack.Run("(" + AwaitEvent("map_exporter") + "mkdir -p $out/log/.probe/in_use; sleep 12; rm -r $out/log/.probe) & " +
            "timeout --signal=INT 20 $run_stack live --out $out");
  INFO(stack.output);
  const std::string begin = "run_stack: --out " + stack.Path("out") + ": ";
  CHECK(stack.Said(begin + "cannot be written: cannot write " + stack.Path("out/log/.probe") + ": Is a directory: "));
  CHECK(stack.Said(begin + "can be written again\n"));
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
