// map_viewer as it is started: by run_stack, for a finished run, for several robots, and wrongly.

#include <algorithm>

#include "catch.hpp"
#include "viewer_page.hpp"

using namespace crsm;

TEST_CASE("run_stack --view says where the map is, and its folder is shown without a bus afterwards", "[viewer]") {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  Process stack("run_stack", {"sim:block", "--out", out, "--lcm-url", MakeBusUrl(), "--view", "--http", "127.0.0.1:0"},
                folder / "log");
  REQUIRE(WaitUntil([&] { return stack.errors().find("run_stack: the map is at http://127.0.0.1:") == 0; }));
  REQUIRE(stack.AwaitExit() == 0);

  Viewer viewer({out}, folder);
  REQUIRE(viewer.AwaitReady());
  Page page(viewer.port());
  REQUIRE(page.Await([&] { return page->complete && page->num_robots > 0 && !page->info.is_null(); }));
  const auto summary = nlohmann::json::parse(ReadFile(folder / "out/summary.json"));
  CHECK(page->version == summary["map_version"]);
  CHECK(page->info["scans"] == summary["scans"]);
  CHECK(page->info["live"] == false);
  CHECK(page->info["loops"].size() == summary["loops"]["closed"]);
  CHECK(page->info["loops"].size() > 0);
  double area_m2 = 0.0;
  for (const auto& [index, cells] : page->tiles) {
    for (const std::uint8_t byte : cells) area_m2 += byte == kUnexploredByte ? 0.0 : 0.05 * 0.05;
  }
  CHECK(area_m2 == Approx(summary["explored_area_m2"].get<double>()).epsilon(1e-3));  // printed with three digits
  CHECK(viewer.process().Interrupt() == 0);
}

TEST_CASE("several robots are shown side by side, each with its own scans", "[viewer]") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Viewer viewer({"--lcm-url", url, "--robots", "robot1/", "robot2/"}, folder);
  REQUIRE(viewer.AwaitReady());
  Page first(viewer.port(), "robot=0");
  Page second(viewer.port(), "robot=1");
  TestBus one(url, "robot1/");
  TestBus two(url, "robot2/");
  scan_match_t match = MatchOf(1);
  const auto Publish = [&](TestBus& bus, double x_m) {
    match.x_m = x_m;
    bus->Publish(kScanMatchChannel, match);
  };
  const auto Shows = [&](Page& page, double x_m) {
    return page.Await([&] {
      match.utime += 1;
      Publish(one, 1.5);
      Publish(two, 2.5);
      return page->num_robots > 0 && page->robot_x_m == x_m;
    });
  };
  CHECK(Shows(first, 1.5));
  CHECK(Shows(second, 2.5));
  CHECK(first->info["robots"] == nlohmann::json({"robot1/", "robot2/"}));
  CHECK(second->info["robot"] == "robot2/");
}

TEST_CASE("a viewer that cannot show what it was asked for says why in one line", "[viewer]") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  Viewer first({"--lcm-url", url}, folder);
  REQUIRE(first.AwaitReady());
  const std::string taken = "127.0.0.1:" + std::to_string(first.port());
  struct Case {
    std::vector<std::string> arguments;
    std::string expected;
    int exit_code;
  };
  for (const Case& wrong : std::vector<Case>{
           {{"--lcm-url", url, "--http", taken}, "--http " + taken + ": Address already in use", 1},
           {{"--lcm-url", url, "--http", "192.0.2.1:8765"}, "--http 192.0.2.1:8765: ", 1},
           {{"--lcm-url", url, "--http", "here"}, "--http: 'here' is not ADDRESS:PORT", 2},
           {{folder / "nowhere"}, "there is no file " + (folder / "nowhere/journal/journal.lcm").string(), 1},
           {{folder / "nowhere", "--channel-prefix", "a/"}, "--channel-prefix: is of a bus", 2},
           {{folder / "nowhere", "--robots", "a/"}, "--robots: are live", 2},
       }) {
    Process viewer("map_viewer", wrong.arguments, folder / "log");
    CHECK(viewer.AwaitExit() == wrong.exit_code);
    const std::string said = viewer.errors();
    CAPTURE(said, wrong.expected);
    CHECK(said.find("map_viewer: " + wrong.expected) == 0);
    CHECK(std::count(said.begin(), said.end(), '\n') == 1);
  }
}
