// A robot that is localised on a finished map: who may tell it where it is, and what becomes of it when the map is
// replaced under it.

#include <csignal>
#include <filesystem>

#include "catch.hpp"
#include "processes.hpp"
#include "services/bus/bus_role.hpp"
#include "services/wire/conversions.hpp"

using namespace crsm;

namespace {

namespace fs = std::filesystem;

/// A map, and another day in its building.
struct Localization {
  TemporaryFolder folder;
  std::string url = MakeBusUrl();

  Localization() {
    folder.Map(folder.Write(TakeScans("sim:demo", 200, 2), "first.lcm"), "map");
    folder.Write(TakeScans("sim:demo", 200, 2, 2), "second.lcm");
  }
  /// Live, at that many times its pace.
  Process Start(const std::string& rate) const {
    return folder.StartStack(folder / "second.lcm", "out", url,
                             {"--localize", folder / "map", "--start", "0,0,0", "--rate", rate});
  }
};

}  // namespace

TEST_CASE("only who has the role tells a localised robot where it is, by name, and the verdict says so") {
  const Localization course;
  TestBus bus(course.url);
  int num_matches = 0;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t&) { ++num_matches; });
  Process stack = course.Start("4");
  const auto Tell = [&](const std::string& awaited) {
    const int num_before = num_matches;
    return bus.Await([&] { return num_matches > num_before + 3; }) && bus.Await([&] {
      bus->Publish(kStartPoseChannel, ToPoseMessage(0, {7.0, 0.0, 0.0}));
      return stack.errors().find(awaited) != std::string::npos || !stack.IsRunning();
    });
  };
  CHECK(Tell(" is refused: only map_viewer, or another process with the role guide, may tell where the robot is"));
  CHECK(stack.errors().find("the next scan is searched there") == std::string::npos);
  {
    const BusRole role({course.url, ""}, kGuideRole);
    CHECK(Tell(": the robot is at x 7.00 m, y 0.00 m, yaw 0.00 rad: the next scan is searched there"));
  }
  REQUIRE(bus.Await([&] { return !stack.IsRunning(); }));
  CHECK(stack.AwaitExit() == 0);
  const std::string verdict = course.folder.Summary("out")["verdict"].dump();
  CHECK(verdict.find("the robot was told where it is ") != std::string::npos);
  CHECK(CountOf(" is refused: ", stack.errors()) == 1);
}

TEST_CASE("a localization whose map is replaced by another one ends when the map is read again, and says why") {
  const Localization course;
  course.folder.Map(course.folder.Write(TakeScans("sim:rooms", 100, 2), "other.lcm"), "other");
  TestBus bus(course.url);
  int num_matches = 0;
  bus->Subscribe<scan_match_t>(kScanMatchChannel, [&](const scan_match_t&) { ++num_matches; });
  Process stack = course.Start("1");
  REQUIRE(bus.Await([&] { return num_matches > 5; }));
  fs::rename(course.folder / "map", course.folder / "before");
  fs::rename(course.folder / "other", course.folder / "map");
  kill(FindChild(stack.pid(), "map_updater"), SIGKILL);
  CHECK(stack.AwaitExit() == 1);
  const std::string said = stack.errors();
  INFO(said);
  CHECK(said.find("localises on another map (") != std::string::npos);
  CHECK(said.find("no verdict is given") != std::string::npos);
}

TEST_CASE("a map whose summary is of another one is not localised on, nor continued") {
  const Localization course;
  course.folder.Map(course.folder / "second.lcm", "other");
  fs::copy_file(course.folder / "other/summary.json", course.folder / "map/summary.json",
                fs::copy_options::overwrite_existing);
  const std::string log = course.folder / "second.lcm";
  for (const char* how : {"--localize", "--resume"}) {
    for (const char* program : {"slam_offline", "run_stack"}) {
      course.folder.CheckRefused(program, {log, "--out", course.folder / "x", how, course.folder / "map"},
                                 "its summary.json is of another map than its journal", 1);
    }
  }
  course.folder.CheckRefused("map_updater", {"--lcm-url", course.url, "--localize", course.folder / "map"},
                             "its summary.json is of another map than its journal", 1);
}
