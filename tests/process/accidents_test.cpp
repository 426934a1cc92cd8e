// What befalls a process that is nobody's fault of the log: streams that are closed, limits of the system, a folder
// that goes, and a second program that would write to the same journal.

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>

#include "catch.hpp"
#include "processes.hpp"
#include "services/journal/journal.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

bool Has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// slam_offline by way of a shell, which closes or limits something.
Ended RunInShell(const TemporaryFolder& folder, const std::string& before, const std::string& arguments,
                 const std::string& behind = "") {
  return folder.Run("/bin/bash",
                    {"-c", fmt::format("{} exec {}/slam_offline {} {}", before, CRSM_BIN_DIR, arguments, behind)});
}

/// A drive that takes some seconds.
std::string WriteLongDrive(const TemporaryFolder& folder) {
  const std::string world = (folder / "long.world").string();
  std::ofstream file(world);
  file << ReadFile(std::string(CRSM_SOURCE_DIR) + "/common/worlds/demo.world");
  for (int i = 0; i < 60; ++i) file << "waypoint 4.6 6.3\nwaypoint 4.6 5\n";
  return "sim:" + world;
}

}  // namespace

TEST_CASE("closed streams change nothing: what is said does not go into a file of ours") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 600), "scans");
  folder.Map(log, "expected");
  CHECK(RunInShell(folder, "", fmt::format("{} --out {}", log, (folder / "out").string()), "<&- >&- 2>&-").exit_code ==
        0);
  folder.CheckSame("out", "expected");
  CHECK(ReadFile(folder / "out/journal/journal.lcm").size() ==
        ReadFile(folder / "expected/journal/journal.lcm").size());
}

TEST_CASE("a file that may grow no further is an error that is said, and the journal has what came before") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 1500), "scans");
  const Ended ended = RunInShell(folder, "ulimit -f 300;", fmt::format("{} --out {}", log, (folder / "out").string()));
  CHECK(ended.exit_code == 1);
  CHECK(Has(ended.errors, "journal.lcm: cannot be written: File too large"));
  folder.Map(log, "expected");
  const Ended resumed = folder.Run("slam_offline", {log, "--resume", folder / "out", "--out", folder / "out"});
  CHECK(resumed.exit_code == 0);
  folder.CheckSame("out", "expected", {"trajectory.tum"});
}

TEST_CASE("the end of the terminal ends a run as Ctrl-C does: the map so far is written") {
  const TemporaryFolder folder;
  Process program("slam_offline", {WriteLongDrive(folder), "--out", folder / "out"}, folder / "log");
  while (!fs::exists(folder / "out/journal/journal.lcm") || fs::file_size(folder / "out/journal/journal.lcm") == 0)
    REQUIRE(program.IsRunning());
  program.Signal(SIGHUP);
  CHECK(program.AwaitExit() == 0);
  CHECK(fs::exists(folder / "out/map.png"));
}

TEST_CASE("a folder that is moved away in a run is said, and no results are written in its place") {
  const TemporaryFolder folder;
  Process program("slam_offline", {WriteLongDrive(folder), "--out", folder / "out"}, folder / "log");
  while (!fs::exists(folder / "out/journal/journal.lcm") || fs::file_size(folder / "out/journal/journal.lcm") == 0)
    REQUIRE(program.IsRunning());
  fs::rename(folder / "out", folder / "elsewhere");
  CHECK(program.AwaitExit() == 1);
  CHECK(Has(program.errors(), "was removed, moved or replaced meanwhile: no results are written"));
  CHECK_FALSE(fs::exists(folder / "out/map.png"));
}

TEST_CASE("a run whose journal is replaced by that of another map ends, and says why") {
  const TemporaryFolder folder;
  folder.Map(folder.Write(TakeScans("sim:demo", 100), "other.lcm"), "other");
  Process stack("run_stack",
                {WriteLongDrive(folder), "--out", folder / "out", "--rate", "20", "--lcm-url", MakeBusUrl()},
                folder / "log");
  const fs::path journal = folder / "out/journal/journal.lcm";
  const auto IsBegun = [&] { return fs::exists(folder / "out/map.png") && ReadHead(folder / "out/journal"); };
  while (!IsBegun()) REQUIRE(stack.IsRunning());
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // run_stack has seen whose journal it is
  fs::copy_file(folder / "other/journal/journal.lcm", folder / "out/journal/copy");
  fs::rename(folder / "out/journal/copy", journal);
  const auto replaced = ReadFile(journal);
  CHECK(stack.AwaitExit() == 1);
  CHECK(Has(stack.errors(), "this folder or its journal was removed, moved or replaced: the run ends"));
  CHECK(Has(stack.errors(), "no verdict is given"));
  CHECK(ReadFile(journal) == replaced);
  // What was written of the map until then is not taken for that of the other one.
  const Ended summary = folder.Run("slam_eval", {"summary", folder / "out"});
  INFO(summary.output);
  CHECK(Has(summary.output, "of another map than its journal"));
}

TEST_CASE("map_updater whose journal is replaced says so, and does not write into that of another map") {
  const TemporaryFolder folder;
  folder.Map(folder.Write(TakeScans("sim:demo", 100), "other.lcm"), "other");
  const fs::path journal = folder / "own/journal.lcm";
  const std::string url = MakeBusUrl();
  TestBus bus(url);
  std::string identity;
  bool is_without_journal = false;
  bus->Subscribe<service_status_t>("SERVICE_STATUS/map_updater", [&](const service_status_t& status) {
    const auto found = std::ranges::find(status.parameter_name, "identity");
    identity = found == status.parameter_name.end()
                   ? ""
                   : status.parameter_value[static_cast<std::size_t>(found - status.parameter_name.begin())];
    is_without_journal = std::ranges::find(status.counter_name, "journal_failed") != status.counter_name.end();
  });
  Process owner("map_updater", {"--journal", folder / "own", "--lcm-url", url}, folder / "log");
  REQUIRE(owner.AwaitReady());
  REQUIRE(bus.Await([&] { return !identity.empty(); }));
  const std::string own_identity = identity;
  fs::remove(journal);
  fs::copy_file(folder / "other/journal/journal.lcm", journal);
  CHECK(bus.Await([&] { return is_without_journal; }));
  CHECK(identity == own_identity);  // so that its map is not taken for that of the other one
  owner.Signal(SIGTERM);
  CHECK(owner.AwaitExit() == 0);
  CHECK(Has(owner.errors(), journal.string() + ": was removed, moved or replaced; mapping goes on without a journal"));
  CHECK(ReadFile(journal) == ReadFile(folder / "other/journal/journal.lcm"));
}

TEST_CASE("a journal has one writer, be it begun or gone on with by map_updater or by slam_offline") {
  const TemporaryFolder folder;
  const std::string log = folder.Write(TakeScans("sim:demo", 300), "scans");
  const std::string out = (folder / "out").string();
  const auto Refuse = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> arguments{log, "--out", out};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const Ended ended = folder.Run("slam_offline", arguments);
    CHECK(ended.exit_code == 1);
    INFO(ended.errors);
    CHECK(Has(ended.errors, "journal.lcm: "));
    CHECK(Has(ended.errors, "writes there"));
  };
  const std::string journal = (folder / "out/journal").string();
  const std::vector<std::string> own{"--journal", journal, "--lcm-url", MakeBusUrl()};
  {
    Process owner("map_updater", own, folder / "log");
    REQUIRE(owner.AwaitReady());
    Refuse({});
  }
  fs::remove_all(out);
  folder.Map(log, "out");
  std::vector<std::string> resumed = own;
  resumed.emplace_back("--resume");
  Process owner("map_updater", resumed, folder / "log");
  REQUIRE(owner.AwaitReady());
  Refuse({"--resume", out});
}
