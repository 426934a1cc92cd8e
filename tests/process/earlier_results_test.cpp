// What slam_offline and run_stack do with results that are in their folder already.

#include <filesystem>
#include <fstream>
#include <map>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace fs = std::filesystem;

namespace {

/// A folder with a log of ten scans and, in out/, its map.
struct Mapped {
  std::string program;
  TemporaryFolder folder = {};
  std::string out = folder / "out";
  std::string log = folder.Write(TakeScans("sim:demo", 10), "run.lcm");
  std::string errors = {};

  explicit Mapped(const std::string& by) : program(by) { REQUIRE(Map({}) == 0); }

  int Map(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {log, "--out", out, "--lcm-url", MakeBusUrl()});
    const Ended ended = folder.Run(program, flags);
    errors = ended.errors;
    return ended.exit_code;
  }

  /// Those that a second run would write too; what is said is in log/.
  std::map<std::string, std::string> Files() const {
    std::map<std::string, std::string> files = ReadFolder(out);
    std::erase_if(files, [](const auto& file) { return file.first.find("log/") != std::string::npos; });
    return files;
  }
};

const std::vector<std::string> kPrograms{"slam_offline", "run_stack"};

}  // namespace

TEST_CASE(
    "a map that cannot be continued, because its journal is damaged, is left as it is with all that was said of it") {
  for (const std::string& program : kPrograms) {
    Mapped run(program);
    const std::string journal = run.out + "/journal/journal.lcm";
    std::string bytes = ReadFile(journal);
    bytes.replace(bytes.size() / 2, 100, 100, '\0');
    std::ofstream(journal, std::ios::binary) << bytes;
    const auto before = run.Files();
    REQUIRE(before.count("summary.json") == 1);
    CHECK(run.Map({"--resume", run.out}) == 1);
    CHECK(run.errors.find(journal + " is damaged at byte ") != std::string::npos);
    CHECK(run.Files() == before);
  }
}

TEST_CASE("the results of an earlier run are left as they are, and the three ways out are said") {
  for (const std::string& program : kPrograms) {
    Mapped run(program);
    const auto before = run.Files();
    REQUIRE(before.count("map.png") == 1);
    CHECK(run.Map({}) == 1);
    CHECK(run.errors == program + ": --out " + run.out + ": holds the results of an earlier run: --resume " + run.out +
                            " continues its map, --force moves them to " + run.out +
                            "/earlier.1, or choose another folder\n");
    // One file of a run is enough.
    for (const std::string file : {"map.png", "map.pgm", "map.yaml", "overview.png", "graph.g2o", "summary.json",
                                   "trajectory.tum", "journal/journal.lcm"}) {
      INFO(program << ' ' << file);
      run.out = run.folder / file;
      fs::create_directories(fs::path(run.out + "/" + file).parent_path());
      std::ofstream(run.out + "/" + file) << "1";
      CHECK(run.Map({}) == 1);
    }
    run.out = run.folder / "out";
    CHECK(run.Files() == before);
  }
}

TEST_CASE("--force moves the results of an earlier run aside, and no other file") {
  for (const std::string& program : kPrograms) {
    Mapped run(program);
    const auto before = run.Files();
    std::ofstream(run.out + "/notes.txt") << "mine\n";
    CHECK(run.Map({"--seed", "2", "--force"}) == 0);
    CHECK(run.errors.find(program + ": the earlier results in " + run.out + " are now in " + run.out +
                          "/earlier.1\n") != std::string::npos);
    auto after = run.Files();
    for (const auto& [name, content] : before) {
      INFO(name);
      CHECK((after["earlier.1/" + name] == content));
      CHECK_FALSE(after[name].empty());
    }
    CHECK(after["notes.txt"] == "mine\n");
    CHECK(run.Map({"--force"}) == 0);
    CHECK(fs::exists(run.out + "/earlier.2/map.png"));
  }
}

TEST_CASE("a run that cannot begin moves nothing aside") {
  for (const std::string& program : kPrograms) {
    Mapped run(program);
    const auto before = run.Files();
    CHECK(run.Map({"--force", "--resume", run.out}) == 2);
    CHECK(run.errors.find("give only one of them") != std::string::npos);
    CHECK(run.Map({"--force", "--localize", run.folder / "nothing"}) == 1);
    run.log = "nonesuch.log";
    CHECK(run.Map({"--force"}) == 1);
    CHECK(run.Files() == before);
  }
}

TEST_CASE("a folder in which a run saw no scan counts as an empty one") {
  for (const std::string& program : kPrograms) {
    Mapped run(program);
    run.out = run.folder / "new";
    fs::create_directories(run.out + "/journal");
    for (const char* name : {"/journal/journal.lcm", "/trajectory.tum"}) std::ofstream(run.out + name).flush();
    for (const char* name : {"/map.png", "/notes.txt"}) std::ofstream(run.out + name) << "mine\n";
    CHECK(run.Map({}) == 0);
    CHECK_FALSE(fs::exists(run.out + "/earlier.1"));
  }
}
