// Who is asked to end while the map of a journal is made again ends at once, and leaves everything as it was.

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "catch.hpp"
#include "processes.hpp"
#include "services/bus/bus_role.hpp"
#include "services/journal/journal.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

/// A journal that takes some seconds to be read: four hundred thousand scans of a robot that stands.
void MakeLongJournal(const fs::path& folder) {
  Journal journal(folder, {false, ListMapParameters({})});
  for (std::int64_t scan = 0; scan < 400'000; ++scan) {
    journal.Append(nullptr, {1'000'000 + scan, {}, 0.9, 1, 1, 0, scan == 0 ? MatchState::kFirst : MatchState::kOk});
  }
  journal.Finish();
}

bool AwaitOwner(const std::string& url) {
  return WaitUntil([&] { return FindRoleHolder({url, ""}, kMapOwnerRole).has_value(); });
}

}  // namespace

TEST_CASE("map_updater ends at once while it reads a journal, and the journal stays as it is") {
  const TemporaryFolder folder;
  MakeLongJournal(folder / "journal");
  const auto before = ReadFolder(folder / "journal");
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string url = MakeBusUrl();
    Process updater("map_updater", {"--lcm-url", url, "--journal", folder / "journal", "--resume"}, folder / "log");
    REQUIRE(AwaitOwner(url));
    updater.Signal(signal);
    CHECK(updater.AwaitExit() == 0);
    CHECK(updater.errors() == "map_updater: stopped before it was ready: nothing was written\n");
    CHECK(ReadFolder(folder / "journal") == before);
  }
}

TEST_CASE("run_stack ends at once while the map of an earlier run is made again, and nothing has changed") {
  const TemporaryFolder folder;
  MakeLongJournal(folder / "map/journal");
  const std::string summary = R"({"of": "an earlier run"})";
  std::ofstream(folder / "map/summary.json") << summary;
  const auto journal = ReadFolder(folder / "map/journal");
  const std::string url = MakeBusUrl();
  Process stack = folder.StartStack("live", "map", url, {"--resume", folder / "map"});
  REQUIRE(AwaitOwner(url));
  stack.Signal(SIGTERM);
  CHECK(stack.AwaitExit() == 0);
  CHECK(stack.errors().find("run_stack: stopped before the first scan was mapped: nothing was written") !=
        std::string::npos);
  CHECK(stack.errors().find("finishing") == std::string::npos);
  CHECK(ReadFolder(folder / "map/journal") == journal);
  CHECK(ReadFile(folder / "map/summary.json") == summary);
  CHECK_FALSE(fs::exists(folder / "map/map.png"));
}

TEST_CASE("each scan of our publisher is in some count, also those that a process has not heard that was stopped") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  constexpr std::int64_t kNumScans = 600;
  const std::string log = folder.Write(TakeScans("sim:demo", kNumScans), "run.lcm");
  Stack stack({url, folder / "out", {}, false});
  REQUIRE(stack.StartServices());
  MapWatcher watcher(url);
  REQUIRE(stack.StartPublisher(log, "20"));
  REQUIRE(watcher.AwaitVersion(50));
  stack["ray_selector"].Signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  REQUIRE(stack.Start("ray_selector"));  // what the other has not read is lost with it
  CHECK(stack.Finish());
  const auto summary = folder.Summary("out");
  CHECK(summary["counts"].value("map_exporter.unheard", 0) > 10);
  CHECK(summary["scans"].get<std::int64_t>() + summary["left_out"].get<std::int64_t>() == kNumScans);
}
