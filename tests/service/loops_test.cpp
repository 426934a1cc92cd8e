// Loops: in one process and in six, over sessions and kills, and on finished maps.

#include <algorithm>
#include <csignal>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kAsMeasured{"--preset", "sick"};

struct Ended {
  int exit_code = 0;
  std::string output;
  std::string errors;
};

Ended RunProgram(const TemporaryFolder& folder, const std::string& program, std::vector<std::string> arguments) {
  Process process(program, arguments, folder / "log");
  const int exit_code = process.AwaitExit();
  return {exit_code, process.output(), process.errors()};
}

Ended MapOffline(const TemporaryFolder& folder, const std::string& log, const std::string& out,
                 std::vector<std::string> flags = {}) {
  flags.insert(flags.begin(), {log, "--out", folder / out});
  flags.insert(flags.end(), kAsMeasured.begin(), kAsMeasured.end());
  return RunProgram(folder, "slam_offline", flags);
}

/// Round the block and somewhat further, so that loops are closed.
struct Course {
  TemporaryFolder folder;
  std::vector<LaserScan> scans = TakeScans("sim:block", 1600);

  std::string WriteFirst(std::size_t count) const {
    const fs::path path = folder / ("first_" + std::to_string(count) + ".lcm");
    WriteScans({scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(std::min(count, scans.size()))}, path);
    return path.string();
  }
};

std::unique_ptr<Process> StartStack(const TemporaryFolder& folder, const std::string& log, const std::string& out,
                                    const std::string& url, std::vector<std::string> flags = {}) {
  flags.insert(flags.begin(), {log, "--out", folder / out, "--lcm-url", url});
  flags.insert(flags.end(), kAsMeasured.begin(), kAsMeasured.end());
  return std::make_unique<Process>("run_stack", flags, folder / "log");
}

void CheckSameResults(const fs::path& out, const fs::path& expected) {
  for (const char* file : {"map.png", "map.yaml", "trajectory.tum", "graph.g2o"}) {
    INFO(file);
    CHECK((ReadFile(out / file) == ReadFile(expected / file)));  // without printing them
  }
}

/// How far poses on a channel are from one to the next.
class Jumps {
 public:
  Jumps(const std::string& url, const char* channel) : bus_(url) {
    bus_->Subscribe<bot_core::pose_t>(channel, [this](const bot_core::pose_t& pose) {
      if (last_)
        longest_m_ = std::max(longest_m_, std::hypot(pose.pos[0] - last_->pos[0], pose.pos[1] - last_->pos[1]));
      last_ = pose;
    });
  }
  TestBus& bus() { return bus_; }
  double longest_m() const { return longest_m_; }

 private:
  TestBus bus_;
  std::optional<bot_core::pose_t> last_;
  double longest_m_ = 0.0;
};

nlohmann::json ReadSummary(const fs::path& out) { return nlohmann::json::parse(ReadFile(out / "summary.json")); }

}  // namespace

TEST_CASE("a run with loops that is cut short and resumed ends with the files of one in one go") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string log = course.WriteFirst(1600);
  const Ended whole = MapOffline(folder, log, "whole");
  REQUIRE(whole.exit_code == 0);
  const auto loops = ReadSummary(folder / "whole")["loops"];
  CHECK(loops["closed"] >= 2);
  CHECK(loops["keyframes"] > 300);
  CHECK(loops["taken_out"] == 0);
  CHECK(whole.output.find(std::to_string(loops["closed"].get<int>()) + " loops closed between ") != std::string::npos);
  CHECK(ReadFile(folder / "whole/graph.g2o").find("VERTEX_SE2 0 0.000000") == 0);

  // Before any loop, and at a place where one has been found and may not have taken effect yet.
  for (const std::size_t cut : {500, 1330, 1340, 1350}) {
    CAPTURE(cut);
    const std::string out = "cut_" + std::to_string(cut);
    REQUIRE(MapOffline(folder, course.WriteFirst(cut), out).exit_code == 0);
    CHECK(ReadFile(folder / out / "map.png") != ReadFile(folder / "whole/map.png"));
    const std::int64_t first_keyframes = ReadSummary(folder / out)["loops"]["keyframes"];
    CHECK(ReadSummary(folder / out)["counts"]["keyframes_searched"] == first_keyframes);
    const Ended resumed = MapOffline(folder, log, out, {"--resume", folder / out});  // --loops is the map's
    INFO(resumed.errors);
    REQUIRE(resumed.exit_code == 0);
    for (const char* file : {"map.png", "map.yaml", "trajectory.tum", "graph.g2o"}) {
      CAPTURE(file);
      CHECK_FALSE(ReadFile(folder / out / file).empty());
      CHECK(ReadFile(folder / out / file) == ReadFile(folder / "whole" / file));
    }
    CHECK(ReadSummary(folder / out)["loops"] == loops);
    CHECK(ReadSummary(folder / out)["counts"]["keyframes_searched"] ==
          loops["keyframes"].get<std::int64_t>() - first_keyframes);
  }
}

TEST_CASE("six processes in lockstep close the loops of slam_offline, and their frame for controllers never jumps") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string log = course.WriteFirst(1600);
  REQUIRE(MapOffline(folder, log, "offline").exit_code == 0);
  const std::string url = MakeBusUrl();
  Jumps map_frame(url, kPoseChannel);
  Jumps local_frame(url, kLocalPoseChannel);
  std::unique_ptr<Process> stack = StartStack(folder, log, "out", url);
  REQUIRE(map_frame.bus().Await([&] { return !stack->IsRunning(); }));
  local_frame.bus().Await([] { return true; });
  CHECK(stack->AwaitExit() == 0);
  CheckSameResults(folder / "out", folder / "offline");
  CHECK(ReadSummary(folder / "out")["loops"] == ReadSummary(folder / "offline")["loops"]);
  CHECK(map_frame.longest_m() > 0.6);     // where the map is put right
  CHECK(local_frame.longest_m() < 0.35);  // as far as the robot drives between two scans
}

TEST_CASE("pieces that are not joined with the map have maps of their own, the same from one process and from six") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  std::vector<LaserScan> scans(course.scans.begin(), course.scans.begin() + 450);
  scans.insert(scans.end(), course.scans.begin() + 700, course.scans.begin() + 900);  // a minute later, elsewhere
  for (std::size_t i = 450; i < scans.size(); ++i) scans[i].utime += 60'000'000;
  const std::string log = folder / "log_with_gap.lcm";
  WriteScans(scans, log);
  const Ended ended = MapOffline(folder, log, "offline");
  REQUIRE(ended.exit_code == 0);
  CHECK(ended.errors.find("scan 450: no scan came for ") != std::string::npos);
  CHECK(ended.output.find("warning: the map is in 2 pieces: the largest has 450 of 650 mapped scans; see pieces/") !=
        std::string::npos);
  const nlohmann::json summary = ReadSummary(folder / "offline");
  CHECK(summary["pieces"]["count"] == 2);
  REQUIRE(summary["breaks"].size() == 1);
  CHECK(summary["breaks"][0]["scan"] == 450);
  CHECK(summary["breaks"][0]["reason"] == "gap");
  CHECK(summary["breaks"][0]["joined"] == false);
  const std::string trajectory = ReadFile(folder / "offline/pieces/2/trajectory.tum");
  CHECK(std::count(trajectory.begin(), trajectory.end(), '\n') == 200);

  fs::create_directories(folder / "out/pieces/7");
  std::ofstream(folder / "out/pieces/7/map.png") << "of an earlier writing";
  const std::string url = MakeBusUrl();
  const auto stack = StartStack(folder, log, "out", url);
  CHECK(stack->AwaitExit() == 0);
  INFO(stack->errors());
  CheckSameResults(folder / "out", folder / "offline");
  CHECK_FALSE(fs::exists(folder / "out/pieces/7"));
  for (const char* file : {"map.png", "map.pgm", "map.yaml", "trajectory.tum"}) {
    INFO(file);
    CHECK_FALSE(ReadFile(folder / "offline/pieces/2" / file).empty());
    CHECK((ReadFile(folder / "out/pieces/2" / file) == ReadFile(folder / "offline/pieces/2" / file)));
  }
  CHECK(ReadSummary(folder / "out")["pieces"] == summary["pieces"]);
  CHECK(ReadSummary(folder / "out")["breaks"] == summary["breaks"]);
  CHECK((stack->output() + stack->errors()).find("scan 450: no scan came for ") != std::string::npos);
}

TEST_CASE("a loop closer that is killed, again and again, comes to the same loops") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string log = course.WriteFirst(1600);
  REQUIRE(MapOffline(folder, log, "offline").exit_code == 0);
  const std::string url = MakeBusUrl();
  MapWatcher map(url);
  Stack stack({url, folder / "out", kAsMeasured});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(log, "max"));
  for (const std::int64_t version : {200, 1300, 1350, 1400}) {
    REQUIRE(map.AwaitVersion(version));
    stack["loop_closer"].Signal(SIGKILL);
    REQUIRE(stack.Start("loop_closer"));
  }
  CHECK(stack.Finish());
  for (const char* file : {"map.png", "trajectory.tum"}) {
    INFO(file);
    CHECK(ReadFile(folder / "out" / file) == ReadFile(folder / "offline" / file));
  }
  const nlohmann::json summary = ReadSummary(folder / "out");
  // The last one that was started has searched at an eighth of them, and at some that nobody had been told of.
  CHECK(summary["counts"]["loop_closer.keyframes_searched"] < 80);
  CHECK(summary["loops"]["keyframes"] > 300);
}

TEST_CASE("a map with loops goes on in one process or in six, whoever began it") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string log = course.WriteFirst(1600);
  REQUIRE(MapOffline(folder, log, "whole").exit_code == 0);
  for (const std::size_t cut : {1330, 1350}) {
    CAPTURE(cut);
    const std::string part = course.WriteFirst(cut);
    REQUIRE(MapOffline(folder, part, "offline_first").exit_code == 0);
    const std::int64_t first_keyframes = ReadSummary(folder / "offline_first")["loops"]["keyframes"];
    const auto resumed = StartStack(folder, log, "offline_first", MakeBusUrl(), {"--resume", folder / "offline_first"});
    INFO(resumed->errors());
    CHECK(resumed->AwaitExit() == 0);
    CheckSameResults(folder / "offline_first", folder / "whole");
    const nlohmann::json summary = ReadSummary(folder / "offline_first");
    CHECK(summary["counts"]["loop_closer.keyframes_searched"] ==
          summary["loops"]["keyframes"].get<std::int64_t>() - first_keyframes);
    fs::remove_all(folder / "offline_first");

    CHECK(StartStack(folder, part, "stack_first", MakeBusUrl())->AwaitExit() == 0);
    CHECK(MapOffline(folder, log, "stack_first", {"--resume", folder / "stack_first"}).exit_code == 0);
    CheckSameResults(folder / "stack_first", folder / "whole");
    fs::remove_all(folder / "stack_first");
  }
}

TEST_CASE("the map's owner that waits for a loop closer in lockstep says so") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string url = MakeBusUrl();
  Stack stack({url, folder / "out", kAsMeasured});
  for (const char* service : {"map_updater", "rrhc_matcher", "ray_selector", "map_exporter"}) {
    REQUIRE(stack.Start(service));
  }
  REQUIRE(stack.StartPublisher(course.WriteFirst(200), "max"));
  CHECK(WaitUntil([&] {
    return stack["map_updater"].errors().find("has waited 5 s for loop_closer to search for loops in 10 keyframes") !=
           std::string::npos;
  }));
  REQUIRE(stack.Start("loop_closer"));
  CHECK(stack.Finish());
}

TEST_CASE("a robot is localised on a map that was made with loops, as it was put right") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  REQUIRE(MapOffline(folder, course.WriteFirst(1600), "map").exit_code == 0);
  const std::string log = folder / "again.lcm";
  WriteScans({course.scans.begin() + 1450, course.scans.begin() + 1500}, log);
  const Ended localised = MapOffline(folder, log, "localised", {"--localize", folder / "map"});
  INFO(localised.errors);
  REQUIRE(localised.exit_code == 0);
  CHECK(localised.output.find("50 scans, 0 lost") == 0);
  CHECK_FALSE(fs::exists(folder / "localised/graph.g2o"));
  CHECK_FALSE(ReadSummary(folder / "localised").contains("loops"));

  const auto stack = StartStack(folder, log, "localised_by_stack", MakeBusUrl(), {"--localize", folder / "map"});
  INFO(stack->errors());
  CHECK(stack->AwaitExit() == 0);
  CheckSameResults(folder / "localised_by_stack", folder / "localised");
}

TEST_CASE("without loops there is neither a graph nor a word of loops, and a map is not mixed of both") {
  const Course course;
  const TemporaryFolder& folder = course.folder;
  const std::string log = course.WriteFirst(30);
  const Ended plain = MapOffline(folder, log, "out", {"--no-loops"});
  REQUIRE(plain.exit_code == 0);
  CHECK(plain.output.find("loops") == std::string::npos);
  CHECK_FALSE(fs::exists(folder / "out/graph.g2o"));
  CHECK_FALSE(ReadSummary(folder / "out").contains("loops"));

  const Ended mixed = MapOffline(folder, log, "out", {"--resume", folder / "out", "--loops"});
  CHECK(mixed.exit_code == 2);
  CHECK(mixed.errors.find("was made with false") != std::string::npos);

  // What an earlier run with loops left goes aside with the rest.
  REQUIRE(MapOffline(folder, log, "out", {"--force"}).exit_code == 0);
  REQUIRE(fs::exists(folder / "out/graph.g2o"));
  REQUIRE(MapOffline(folder, log, "out", {"--no-loops", "--force"}).exit_code == 0);
  CHECK_FALSE(fs::exists(folder / "out/graph.g2o"));
  CHECK(fs::exists(folder / "out/earlier.2/graph.g2o"));
}
