// Loops: in one process and in six, over sessions and kills, and on finished maps.

#include <algorithm>
#include <csignal>
#include <fstream>
#include <optional>

#include "catch.hpp"
#include "processes.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kAsMeasured{"--preset", "sick"};

const std::vector<std::string> kLoopFiles{"map.png", "map.yaml", "trajectory.tum", "graph.g2o"};

/// Round the block and somewhat further, so that loops are closed.
struct Course : TemporaryFolder {
  std::vector<LaserScan> scans = TakeScans("sim:block", 1600);

  std::string WriteFirst(std::size_t count) const {
    return Write({scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(std::min(count, scans.size()))},
                 "first_" + std::to_string(count) + ".lcm");
  }

  // With the preset.
  Ended Map(const std::string& log, const std::string& out, const std::vector<std::string>& flags = {}) const {
    return TemporaryFolder::Map(log, out, With(flags));
  }
  Ended MapWithStack(const std::string& log, const std::string& out, const std::vector<std::string>& flags = {}) const {
    return TemporaryFolder::MapWithStack(log, out, With(flags));
  }

  static std::vector<std::string> With(std::vector<std::string> flags) {
    flags.insert(flags.end(), kAsMeasured.begin(), kAsMeasured.end());
    return flags;
  }
};

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

/// Of 650 scans 200 are on another piece: each is counted once, and none of them is lost.
void CheckApart(const nlohmann::json& summary) {
  CHECK(summary["scans"] == 650);
  CHECK(summary["on_map"] == 450);
  CHECK(summary["floating"] == 200);
  CHECK(summary["lost"] == 0);
  CHECK(summary["path_length_m"] < 1.1 * summary["pieces"]["largest_first"][0]["way_m"].get<double>());
  CHECK(summary["verdict"]["off_m"] < 1.0);
}

}  // namespace

TEST_CASE("a run with loops that is cut short and resumed ends with the files of one in one go") {
  const Course course;
  const std::string log = course.WriteFirst(1600);
  const Ended whole = course.Map(log, "whole");
  const auto loops = course.Summary("whole")["loops"];
  CHECK(loops["closed"] >= 2);
  CHECK(loops["keyframes"] > 300);
  CHECK(loops["rejected"] == 0);
  CHECK(whole.output.find(std::to_string(loops["closed"].get<int>()) + " loops closed between ") != std::string::npos);
  CHECK(ReadFile(course / "whole/graph.g2o").starts_with("VERTEX_SE2 0 0 0 0\n"));

  // Before any loop, and at a place where one has been found and may not have taken effect yet.
  for (const std::size_t cut : {500, 1330, 1340, 1350}) {
    CAPTURE(cut);
    const std::string out = "cut_" + std::to_string(cut);
    course.Map(course.WriteFirst(cut), out);
    CHECK(ReadFile(course / out / "map.png") != ReadFile(course / "whole/map.png"));
    const std::int64_t first_keyframes = course.Summary(out)["loops"]["keyframes"];
    CHECK(course.Summary(out)["counts"]["keyframes_searched"] == first_keyframes);
    course.Map(log, out, {"--resume", course / out});  // --loops is the map's
    course.CheckSame(out, "whole", kLoopFiles);
    CHECK(course.Summary(out)["loops"] == loops);
    CHECK(course.Summary(out)["counts"]["keyframes_searched"] ==
          loops["keyframes"].get<std::int64_t>() - first_keyframes);
  }
}

TEST_CASE("six processes in lockstep close the loops of slam_offline, and their frame for controllers never jumps") {
  const Course course;
  const std::string log = course.WriteFirst(1600);
  course.Map(log, "offline");
  const std::string url = MakeBusUrl();
  Jumps map_frame(url, kPoseChannel);
  Jumps local_frame(url, kLocalPoseChannel);
  Process stack = course.StartStack(log, "out", url, kAsMeasured);
  REQUIRE(map_frame.bus().Await([&] { return !stack.IsRunning(); }));
  local_frame.bus().Await([] { return true; });
  CHECK(stack.AwaitExit() == 0);
  course.CheckSame("out", "offline", kLoopFiles);
  CHECK(course.Summary("out")["loops"] == course.Summary("offline")["loops"]);
  CHECK(map_frame.longest_m() > 0.6);     // where the map is corrected
  CHECK(local_frame.longest_m() < 0.35);  // as far as the robot drives between two scans
}

TEST_CASE("pieces that are not joined with the map have maps of their own, the same from one process and from six") {
  const Course course;
  std::vector<LaserScan> scans(course.scans.begin(), course.scans.begin() + 450);
  scans.insert(scans.end(), course.scans.begin() + 700, course.scans.begin() + 900);  // a minute later, elsewhere
  for (std::size_t i = 450; i < scans.size(); ++i) scans[i].utime += 60'000'000;
  const std::string log = course.Write(scans, "log_with_gap.lcm");
  const Ended ended = course.Map(log, "offline");
  CHECK(ended.errors.find("scan 450: no scan came for ") != std::string::npos);
  CHECK(ended.output.find("450 of 650 scans mapped, 200 floating (on another piece), 0 lost, ") != std::string::npos);
  CHECK(ended.output.find("warning: the map is in 2 pieces: the largest, which is shown, has 69 % of the scans that "
                          "measured anything; see pieces/") != std::string::npos);
  const nlohmann::json summary = course.Summary("offline");
  CheckApart(summary);
  CHECK(CountLines(ReadFile(course / "offline/trajectory.tum")) == 450);
  CHECK(summary["pieces"]["count"] == 2);
  REQUIRE(summary["breaks"].size() == 1);
  CHECK(summary["breaks"][0]["scan"] == 450);
  CHECK(summary["breaks"][0]["reason"] == "gap");
  CHECK(summary["breaks"][0]["joined"] == false);
  CHECK(CountLines(ReadFile(course / "offline/pieces/2/trajectory.tum")) == 200);

  fs::create_directories(course / "out/pieces/7");
  std::ofstream(course / "out/pieces/7/map.png") << "of an earlier writing";
  const Ended stack = course.MapWithStack(log, "out");
  course.CheckSame("out", "offline", kLoopFiles);
  CHECK_FALSE(fs::exists(course / "out/pieces/7"));
  course.CheckSame("out/pieces/2", "offline/pieces/2", {"map.png", "map.pgm", "map.yaml", "trajectory.tum"});
  CheckApart(course.Summary("out"));
  CHECK(course.Summary("out")["path_length_m"] == summary["path_length_m"]);
  CHECK(course.Summary("out")["pieces"] == summary["pieces"]);
  CHECK(course.Summary("out")["breaks"] == summary["breaks"]);
  CHECK((stack.output + stack.errors).find("scan 450: no scan came for ") != std::string::npos);
}

TEST_CASE("a loop closer that is killed, again and again, comes to the same loops") {
  const Course course;
  const std::string log = course.WriteFirst(1600);
  course.Map(log, "offline");
  const std::string url = MakeBusUrl();
  MapWatcher map(url);
  Stack stack({url, course / "out", kAsMeasured});
  REQUIRE(stack.StartServices());
  REQUIRE(stack.StartPublisher(log, "max"));
  for (const std::int64_t version : {200, 1300, 1350, 1400}) {
    REQUIRE(map.AwaitVersion(version));
    stack["loop_closer"].Signal(SIGKILL);
    REQUIRE(stack.Start("loop_closer"));
  }
  CHECK(stack.Finish());
  course.CheckSame("out", "offline");
  const nlohmann::json summary = course.Summary("out");
  // The last one that was started has searched at an eighth of them, and at some that nobody had been told of.
  CHECK(summary["counts"]["loop_closer.keyframes_searched"] < 80);
  CHECK(summary["loops"]["keyframes"] > 300);
}

TEST_CASE("a map with loops goes on in one process or in six, whoever began it") {
  const Course course;
  const std::string log = course.WriteFirst(1600);
  course.Map(log, "whole");
  for (const std::size_t cut : {1330, 1350}) {
    CAPTURE(cut);
    const std::string part = course.WriteFirst(cut);
    course.Map(part, "offline_first");
    const std::int64_t first_keyframes = course.Summary("offline_first")["loops"]["keyframes"];
    course.MapWithStack(log, "offline_first", {"--resume", course / "offline_first"});
    course.CheckSame("offline_first", "whole", kLoopFiles);
    const nlohmann::json summary = course.Summary("offline_first");
    CHECK(summary["counts"]["loop_closer.keyframes_searched"] ==
          summary["loops"]["keyframes"].get<std::int64_t>() - first_keyframes);
    fs::remove_all(course / "offline_first");

    course.MapWithStack(part, "stack_first");
    course.Map(log, "stack_first", {"--resume", course / "stack_first"});
    course.CheckSame("stack_first", "whole", kLoopFiles);
    fs::remove_all(course / "stack_first");
  }
}

TEST_CASE("the map's owner that waits for a loop closer in lockstep says so") {
  const Course course;
  const std::string url = MakeBusUrl();
  Stack stack({url, course / "out", kAsMeasured});
  for (const char* service : {"map_updater", "rrhc_matcher", "ray_selector", "map_exporter"}) {
    REQUIRE(stack.Start(service));
  }
  REQUIRE(stack.StartPublisher(course.WriteFirst(200), "max"));
  CHECK(stack["map_updater"].AwaitSaid("has waited 5 s for loop_closer to search for loops in 6 keyframes"));
  REQUIRE(stack.Start("loop_closer"));
  CHECK(stack.Finish());
}

TEST_CASE("a robot is localised on a map that was made with loops, as it was corrected") {
  const Course course;
  course.Map(course.WriteFirst(1600), "map");
  const std::string log = course.Write({course.scans.begin() + 1450, course.scans.begin() + 1500}, "again.lcm");
  const Ended localised = course.Map(log, "localised", {"--localize", course / "map"});
  CHECK(localised.output.find("50 scans, map of ") == 0);
  CHECK(localised.output.find("50 of 50 scans found on the map, 0 lost, ") != std::string::npos);
  CHECK_FALSE(fs::exists(course / "localised/graph.g2o"));
  CHECK_FALSE(course.Summary("localised").contains("loops"));

  course.MapWithStack(log, "localised_by_stack", {"--localize", course / "map"});
  course.CheckSame("localised_by_stack", "localised");
}

TEST_CASE("without loops there is neither a graph nor a word of loops, and a map is not mixed of both") {
  const Course course;
  const std::string log = course.WriteFirst(30);
  const Ended plain = course.Map(log, "out", {"--no-loops"});
  CHECK(plain.output.find(" closed between ") == std::string::npos);
  CHECK_FALSE(fs::exists(course / "out/graph.g2o"));
  CHECK_FALSE(course.Summary("out").contains("loops"));

  course.CheckRefused("slam_offline", {log, "--out", course / "out", "--resume", course / "out", "--loops"},
                      "was made with false", 2);

  // What an earlier run with loops left goes aside with the rest.
  course.Map(log, "out", {"--force"});
  REQUIRE(fs::exists(course / "out/graph.g2o"));
  course.Map(log, "out", {"--no-loops", "--force"});
  CHECK_FALSE(fs::exists(course / "out/graph.g2o"));
  CHECK(fs::exists(course / "out/earlier.2/graph.g2o"));
}
