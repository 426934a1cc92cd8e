// What slam_offline does with results that are in its folder already: what run_stack does, whose tests are in
// run_stack_folder_test.cpp.

#include <filesystem>
#include <map>

#include "catch.hpp"
#include "processes.hpp"
#include "source_helpers.hpp"

using namespace crsm;

namespace fs = std::filesystem;

namespace {

/// A folder with a log of ten scans and, in out/, its map.
struct Mapped {
  TemporaryFolder folder;
  std::string out = folder / "out";

  Mapped() {
    WriteScans(TakeScans("sim:demo", 10), folder / "run.lcm");
    REQUIRE(Map({}) == 0);
  }

  int Map(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {folder / "run.lcm", "--out", out});
    Process process("slam_offline", flags, folder / "log");
    const int exit_code = process.AwaitExit();
    errors = process.errors();
    return exit_code;
  }

  /// The files below out/, and what is in them.
  std::map<std::string, std::string> Files() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      if (entry.is_regular_file()) files[fs::relative(entry.path(), out).string()] = ReadFile(entry.path());
    }
    return files;
  }

  std::string errors;
};

}  // namespace

TEST_CASE("slam_offline leaves the results of an earlier run as they are, and says the three ways out") {
  Mapped run;
  const auto before = run.Files();
  REQUIRE(before.count("map.png") == 1);
  CHECK(run.Map({}) == 1);
  CHECK(run.errors == "slam_offline: --out " + run.out + ": holds the results of an earlier run: --resume " + run.out +
                          " continues its map, --force moves them to " + run.out +
                          "/earlier.1, or choose another folder\n");
  CHECK(run.Files() == before);
}

TEST_CASE("slam_offline --force moves the results of an earlier run aside, and no other file") {
  Mapped run;
  const auto before = run.Files();
  std::ofstream(run.out + "/notes.txt") << "mine\n";
  CHECK(run.Map({"--seed", "2", "--force"}) == 0);
  CHECK(run.errors.find("slam_offline: the earlier results in " + run.out + " are now in " + run.out +
                        "/earlier.1\n") != std::string::npos);
  auto after = run.Files();
  for (const auto& [name, content] : before) {
    INFO(name);
    CHECK(after["earlier.1/" + name] == content);
    CHECK_FALSE(after[name].empty());
  }
  CHECK(after["notes.txt"] == "mine\n");
  CHECK(run.Map({"--force"}) == 0);
  CHECK(fs::exists(run.out + "/earlier.2/map.png"));
}

TEST_CASE("slam_offline that cannot begin moves nothing aside") {
  Mapped run;
  const auto before = run.Files();
  CHECK(run.Map({"--force", "--resume", run.out}) == 2);
  CHECK(run.errors.find("give only one of them") != std::string::npos);
  CHECK(run.Map({"--force", "--localize", run.folder / "nothing"}) == 1);
  Process no_log("slam_offline", {"nonesuch.log", "--out", run.out, "--force"}, run.folder / "log");
  CHECK(no_log.AwaitExit() == 1);
  CHECK(run.Files() == before);
}

TEST_CASE("slam_offline takes a folder that has no map for an empty one") {
  Mapped run;
  fs::create_directories(run.folder / "new/journal");
  std::ofstream(run.folder / "new/journal/journal.lcm");
  std::ofstream(run.folder / "new/notes.txt") << "mine\n";
  run.out = run.folder / "new";
  CHECK(run.Map({}) == 0);
  CHECK_FALSE(fs::exists(run.folder / "new/earlier.1"));
}
