// map_viewer as it is started: by run_stack, for a finished run, for several robots, and wrongly.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "catch.hpp"
#include "common/metrics/trajectory.hpp"
#include "viewer_page.hpp"

using namespace crsm;

TEST_CASE("run_stack --view says where the map is, and its folder is shown without a bus afterwards", "[viewer]") {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const Ended stack = folder.MapWithStack("sim:block", "out", {"--view", "--http", "127.0.0.1:0"});
  CHECK(stack.errors.find("run_stack: the map is at http://127.0.0.1:") != std::string::npos);

  Viewer viewer({out}, folder);
  REQUIRE(viewer.AwaitReady());
  Page page(viewer.port());
  REQUIRE(page.Await([&] { return page->complete && page->num_robots > 0 && !page->info.is_null(); }));
  const nlohmann::json summary = folder.Summary("out");
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

TEST_CASE("the files of a finished run come to a browser whole, and run.mcap is made for it", "[viewer]") {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  folder.Map("sim:demo", "out");
  Viewer viewer({out}, folder);
  REQUIRE(viewer.AwaitReady());
  const auto Ask = [&](const std::string& target) { return AskHttp(viewer.port(), target); };
  const auto BodyOf = [](const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); };

  const auto list = nlohmann::json::parse(BodyOf(Ask("/files?robot=0")));
  std::vector<std::string> names;
  for (const nlohmann::json& file : list) {
    const std::string name = file["name"];
    names.push_back(name);
    if (name == "run.mcap") continue;
    const std::string answer = Ask("/files/" + name + "?robot=0");
    CHECK(answer.starts_with("HTTP/1.1 200 OK\r\n"));
    CHECK(answer.find("\r\nContent-Disposition: attachment; filename=\"" + name + "\"\r\n") != std::string::npos);
    CHECK((BodyOf(answer) == ReadFile(out + "/" + name)));  // without printing them
    CHECK(file["bytes"] == std::filesystem::file_size(out + "/" + name));
  }
  CHECK(names == std::vector<std::string>{"map.png", "map.pgm", "map.yaml", "overview.png", "trajectory.tum",
                                          "graph.g2o", "summary.json", "run.mcap"});

  const std::string file = folder / "run.mcap";
  REQUIRE(folder.Run("map_viewer", {out, "--mcap", file}).exit_code == 0);
  const std::string mcap = ReadFile(file);
  // Two at a time get the same one; the page is served meanwhile.
  TcpClient first(viewer.port());
  TcpClient second(viewer.port());
  for (TcpClient* client : {&first, &second}) client->Send("GET /files/run.mcap HTTP/1.1\r\nHost: localhost\r\n\r\n");
  CHECK(Ask("/").starts_with("HTTP/1.1 200 OK\r\n"));
  for (TcpClient* client : {&first, &second}) CHECK((BodyOf(client->ReceiveAll()) == mcap));
  // Who leaves gets none, and is no burden to the next.
  TcpClient(viewer.port()).Send("GET /files/run.mcap HTTP/1.1\r\nHost: localhost\r\n\r\n");
  CHECK((BodyOf(Ask("/files/run.mcap")) == mcap));
  TcpClient(viewer.port()).Send("GET /files/run.mcap HTTP/1.1\r\nHost: localhost\r\n\r\n");
  CHECK(viewer.process().Interrupt() == 0);
}

TEST_CASE("a run on a finished map is shown on that map, with its own path alone", "[viewer]") {
  const TemporaryFolder folder;
  folder.Map("sim:demo", "map");
  folder.Map("sim:demo", "today", {"--seed", "2", "--localize", folder / "map"});
  std::filesystem::rename(folder / "map", folder / "elsewhere");  // it is not needed any more

  Viewer viewer({folder / "today", folder / "elsewhere"}, folder);
  REQUIRE(viewer.AwaitReady());
  Page today(viewer.port(), "robot=0");
  Page earlier(viewer.port(), "robot=1");
  for (Page* page : {&today, &earlier}) {
    REQUIRE(page->Await([&] { return (*page)->complete && (*page)->num_robots > 0 && !(*page)->info.is_null(); }));
  }
  CHECK(today->ExploredTiles() == earlier->ExploredTiles());
  const nlohmann::json summary = folder.Summary("today");
  CHECK(today->info["scans"] == summary["scans"]);
  CHECK(today->info["lost"] == summary["lost"]);
  const Trajectory path = ReadTrajectory(folder / "today/trajectory.tum");
  CHECK(today->robot_utime == path.back().utime);
  CHECK(today->robot_x_m == Approx(path.back().T_map_laser.x_m).margin(1e-6));  // as the file is rounded
  REQUIRE(today->path.size() > 100);
  for (const auto& [scan, x_m, y_m, state, trajectory] : today->path) {
    const auto IsThere = [x = x_m, y = y_m](const StampedPose& pose) {
      return std::hypot(pose.T_map_laser.x_m - x, pose.T_map_laser.y_m - y) < 1e-5;
    };
    if (!std::any_of(path.begin(), path.end(), IsThere)) FAIL("(" << x_m << ", " << y_m << ") is not of this run");
  }
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
  const std::string journal = folder / "journal.lcm";
  std::ofstream(journal) << "of an earlier run";
  struct Case {
    std::vector<std::string> arguments;
    std::string expected;
    int exit_code;
  };
  for (const Case& wrong : std::vector<Case>{
           {{"--lcm-url", url, "--http", "192.0.2.1:8765"}, "--http 192.0.2.1:8765: ", 1},
           {{"--lcm-url", url, "--http", "here"}, "--http: 'here' is not ADDRESS:PORT", 2},
           {{folder / "nowhere"}, "there is no file " + (folder / "nowhere/journal/journal.lcm").string(), 1},
           {{folder / "nowhere", "--channel-prefix", "a/"}, "--channel-prefix: applies to live robots only", 2},
           {{folder / "nowhere", "--robots", "a/"}, "--robots: shows live robots", 2},
           {{folder / "nowhere", "--mcap", "/dev/null"}, "--mcap /dev/null: is no regular file", 1},
           {{folder / "nowhere", "--mcap", journal},
            "--mcap " + journal + ": is no MCAP file, and would be overwritten",
            1},
       }) {
    folder.CheckRefused("map_viewer", wrong.arguments, wrong.expected, wrong.exit_code);
  }
}

TEST_CASE("where another program uses the port, run_stack --view takes the next one and says so", "[viewer]") {
  const TemporaryFolder folder;
  Viewer other({"--lcm-url", MakeBusUrl()}, folder);
  REQUIRE(other.AwaitReady());
  const std::string port = std::to_string(other.port());
  const Ended stack = folder.MapWithStack("sim:corridor", "out", {"--view", "--http", "127.0.0.1:" + port});
  INFO(stack.errors);
  const std::string begin = "run_stack: the map is at http://127.0.0.1:";
  const std::size_t at = stack.errors.find(begin);
  REQUIRE(at != std::string::npos);
  CHECK(std::stoi(stack.errors.substr(at + begin.size())) > other.port());
  CHECK(stack.errors.find("/ (port " + port + " is in use)\n") != std::string::npos);
}

TEST_CASE("a viewer that cannot start does not stop the mapping", "[viewer]") {
  const TemporaryFolder folder;
  const Ended stack = folder.MapWithStack("sim:corridor", "out", {"--view", "--http", "192.0.2.1:8765"});
  INFO(stack.errors);
  CHECK(stack.errors.find("run_stack: map_viewer failed (exit code 1): the mapping goes on without it\n") !=
        std::string::npos);
  CHECK(stack.errors.find("map_viewer: --http 192.0.2.1:8765: Cannot assign requested address") != std::string::npos);
  CHECK(folder.Summary("out")["scans"] > 0);
}

TEST_CASE("a viewer takes the token in its environment; what is none is refused", "[viewer]") {
  const TemporaryFolder folder;
  const std::string url = MakeBusUrl();
  const std::string token = "00112233445566778899aabbccddeeff";
  setenv("CRSM_VIEWER_TOKEN", token.c_str(), 1);
  {
    Viewer viewer({"--lcm-url", url, "--http", "0.0.0.0:0"}, folder);
    REQUIRE(viewer.AwaitReady());
    CHECK(viewer.process().errors().find("/#token=" + token) != std::string::npos);
  }
  setenv("CRSM_VIEWER_TOKEN", "secret", 1);
  const std::string expected = "CRSM_VIEWER_TOKEN: is not a token of 32 hexadecimal digits in lower case";
  folder.CheckRefused("map_viewer", {"--lcm-url", url}, expected);
  folder.CheckRefused("run_stack", {"sim:demo", "--lcm-url", url, "--out", folder / "out", "--view"}, expected);
  unsetenv("CRSM_VIEWER_TOKEN");
  CHECK_FALSE(std::filesystem::exists(folder / "out"));
}
