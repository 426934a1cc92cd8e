#include "services/map_viewer/page_feed.hpp"

#include <cmath>

#include "catch.hpp"
#include "page_client.hpp"
#include "services/map_viewer/history.hpp"

namespace crsm {
namespace {

TileBytes Filled(std::uint8_t byte) {
  TileBytes cells;
  cells.fill(byte);
  return cells;
}

/// A tile whose cells all differ from their neighbours, so that nothing of it can be left out.
TileBytes Striped(int seed) {
  TileBytes cells;
  for (int i = 0; i < kTileCells; ++i) cells[static_cast<std::size_t>(i)] = i % 2 == seed % 2 ? 0 : 255;
  return cells;
}

/// A scene, and what a page knows of it.
struct Page : PageClient {
  void TakeAll() {
    while (const auto message = feed.Next()) {
      CHECK_FALSE(message->is_text);
      Take(message->bytes);
    }
  }

  Scene scene{""};
  PageFeed feed{scene, {""}, {}};
};

PathSketch PathOf(int num_matches, double step_m = 1.0) {
  PathSketch path;
  for (int i = 0; i < num_matches; ++i) {
    ScanMatch match;
    match.utime = i;
    match.T_map_laser = {step_m * i, -1.0, 0.0};
    match.num_critical = 60;
    match.state = i == 2 ? MatchState::kLost : MatchState::kOk;
    match.floating = i == 3;
    match.trajectory = i == 3 ? 1 : 0;
    path.Add(match);
  }
  return path;
}

}  // namespace

TEST_CASE("a page that comes late is told the whole map, and then of each tile the cells that have changed") {
  Page page;
  for (int x = 0; x < 3; ++x) page.scene.map().Set({x, -x}, Filled(200), 5);
  page.scene.map().SetVersion(7, 5);
  page.TakeAll();
  CHECK(page.num_begun == 1);
  CHECK(page.complete);
  CHECK((page.epoch == 7 && page.version == 5));
  CHECK(page.num_whole_tiles == 3);
  CHECK_FALSE(page.feed.Next());

  TileBytes changed = Filled(200);
  changed[4095] = 0;
  page.scene.map().Set({1, -1}, changed, 6);
  page.scene.map().Set({2, -2}, Filled(200), 6);  // as it was
  page.scene.map().SetVersion(7, 6);
  const auto message = page.feed.Next();
  REQUIRE(message);
  CHECK(message->bytes.size() < 60);
  page.Take(message->bytes);
  CHECK(page.num_changed_tiles == 1);
  CHECK(page.version == 6);
  CHECK(page.tiles.at({1, -1}) == changed);
  CHECK(page.tiles.at({0, 0}) == Filled(200));
  for (std::size_t i = 0; i < 5; ++i) {  // who has missed changes of a tile is told all of it, as it is now and once
    changed[i] = 10;
    page.scene.map().Set({1, -1}, changed, 7);
  }
  page.TakeAll();
  CHECK((page.num_whole_tiles == 4 && page.num_changed_tiles == 1));
  CHECK(page.tiles.at({1, -1}) == changed);
}

TEST_CASE("no message is much larger than 256 KB, and the robot is told of between the parts of a large map") {
  Page page;
  for (int i = 0; i < 400; ++i) page.scene.map().Set({i % 20, i / 20}, Striped(i), 1);
  page.scene.map().SetVersion(3, 1);
  int num_messages = 0;
  while (const auto message = page.feed.Next()) {
    CHECK(message->bytes.size() < 300 * 1024);
    page.Take(message->bytes);
    CHECK(page.complete == !page.feed.has_more());
    CHECK(page.num_whole_tiles + page.num_left == 400);
    page.scene.SetRobot({});
    if (++num_messages == 20) break;
  }
  CHECK(page.num_robots == 19);
  CHECK(page.num_map_records == 7);
  CHECK(page.num_whole_tiles == 400);
}

TEST_CASE("a page that was cut off goes on where it was, also with a viewer that was started anew") {
  Scene scene("");
  scene.map().Set({0, 0}, Filled(200), 5);
  scene.map().Set({1, 0}, Filled(200), 5);
  scene.map().SetVersion(7, 5);
  scene.map().Set({2, 0}, Filled(200), 8);
  scene.map().SetVersion(7, 8);
  const auto NumTold = [&](std::int64_t epoch, std::int64_t version, int begun) {
    PageFeed feed(scene, {""}, {epoch, version});
    PageClient client;
    while (const auto message = feed.Next()) client.Take(message->bytes);
    CHECK(client.num_begun == begun);
    return client.num_whole_tiles + client.num_changed_tiles;
  };
  CHECK(NumTold(7, 5, 0) == 1);
  CHECK(NumTold(7, 8, 0) == 0);
  CHECK(NumTold(7, 9, 1) == 3);  // which there is not
  CHECK(NumTold(6, 8, 1) == 3);  // of another map
  CHECK(NumTold(7, -1, 1) == 3);
  CHECK(NumTold(0, 0, 1) == 3);
}

TEST_CASE("a map with other cells begins anew") {
  Page page;
  page.scene.map().Set({0, 0}, Filled(200), 5);
  page.TakeAll();
  page.scene.map().Begin(0.02);
  page.scene.map().Set({4, 4}, Filled(10), 1);
  page.TakeAll();
  CHECK(page.num_begun == 2);
  CHECK(page.tiles.size() == 1);
  CHECK(page.tiles.count({4, 4}) == 1);
}

TEST_CASE("of the robot only the newest is told, with its scan") {
  Page page;
  page.TakeAll();
  for (int i = 1; i <= 100; ++i) {
    SceneRobot robot;
    robot.match.utime = i;
    robot.match.T_map_laser.x_m = 0.5 * i;
    robot.match.trajectory = 3 * i;
    robot.match.floating = i == 100;
    robot.scan = {i, {{0.0F, 0.1F}, {3.0F, 4.0F}}, {1}};
    page.scene.SetRobot(robot);
  }
  page.TakeAll();
  CHECK(page.num_robots == 1);
  CHECK(page.robot_utime == 100);
  CHECK(page.robot_x_m == 50.0);
  CHECK(page.robot_trajectory == 300);
  CHECK(page.robot_floats);
  CHECK(page.num_rays == 2);
}

TEST_CASE("the path grows at its end, and is told anew when it is another one") {
  Page page;
  page.scene.SetPath(PathOf(5), true);
  page.TakeAll();
  REQUIRE(page.path.size() == 5);
  CHECK(page.path[2].state == 2);
  CHECK(page.path[3].state == 4);  // it floats
  CHECK((page.path[2].trajectory == 0 && page.path[3].trajectory == 1));
  page.scene.SetPath(PathOf(6), false);
  const auto more = page.feed.Next();
  REQUIRE(more);
  CHECK(more->bytes.size() < 40);
  page.Take(more->bytes);
  CHECK(page.path.size() == 6);
  page.scene.SetPath(PathOf(4, 2.0), true);
  page.TakeAll();
  REQUIRE(page.path.size() == 4);
  CHECK(page.path[3].x_m == 6.0F);
  page.scene.SetPath(PathOf(10000, 2.0), false);  // so long that it was thinned
  page.TakeAll();
  CHECK(page.path.size() == page.scene.path().kept().size());
  CHECK(page.path[1].x_m == static_cast<float>(page.scene.path().kept()[1].match.T_map_laser.x_m));
  CHECK(page.path[1].scan == static_cast<std::uint32_t>(page.scene.path().kept()[1].number));
}

TEST_CASE("of the running curves no more is told than is kept, and no scan twice") {
  Page page;
  for (int i = 0; i < 3000; ++i) page.scene.AddSample({i, static_cast<float>(i), MatchState::kOk});
  page.TakeAll();
  REQUIRE(page.fitnesses.size() == Scene::kMostSamples);
  CHECK(page.fitnesses.front() == 3000 - 1024);
  page.scene.AddSample({3000, 3000.0F, MatchState::kLost});
  page.TakeAll();
  CHECK(page.fitnesses.size() == Scene::kMostSamples + 1);
  CHECK(page.fitnesses.back() == 3000.0F);
}

TEST_CASE("of a run that has ended all scans are told at once, and each of them when it is asked for") {
  Page page;
  Timeline timeline;
  for (int i = 0; i < 5; ++i) {
    ScanMatch match;
    match.utime = 1'000'000 * (i + 1);
    match.T_map_laser = {1.0 * i, 0.0, 0.0};
    match.state = i == 1 ? MatchState::kLost : MatchState::kOk;
    match.num_critical = 20;
    match.floating = i == 4;
    match.trajectory = i / 3;
    if (i == 3) match.degenerate_axis = {0.0, -1.0};
    const CriticalRays scan{match.utime, {{0.0f, 0.5f}, {2.0f, 3.0f}}, {1}};
    timeline.Add(match, i == 2 || i == 3 ? &scan : nullptr);
  }
  ScanMatch corrected = timeline.match(2);
  corrected.T_map_laser.x_m = 2.5;
  timeline.SetMatch(2, corrected);
  page.scene.SetTimeline(timeline);
  page.TakeAll();
  CHECK(page.timeline_time_s == std::vector{1.0, 2.0, 3.0, 4.0, 5.0});
  CHECK(page.timeline_x_m == std::vector{0.0f, 1.0f, 2.5f, 3.0f, 4.0f});
  CHECK(
      (page.timeline_first_x_m[0] == 0.0f && page.timeline_first_x_m[2] == 2.0f && page.timeline_first_x_m[3] == 3.0f));
  for (const std::size_t lost_or_floating : {1UL, 4UL}) CHECK(std::isnan(page.timeline_first_x_m[lost_or_floating]));
  CHECK(page.timeline_axis_rad[3] == Approx(-1.5708).margin(1e-4));
  for (const std::size_t of_no_axis : {0UL, 1UL, 2UL, 4UL}) CHECK(std::isnan(page.timeline_axis_rad[of_no_axis]));
  CHECK(page.timeline_trajectory == std::vector{0, 0, 0, 1, 1});
  CHECK(page.timeline_state == std::vector<std::uint8_t>{1, 2, 1, 1, 4});
  const int num_robots = page.num_robots;
  CHECK(page.feed.Hear("scan 2", true));
  page.TakeAll();
  CHECK((page.num_robots == num_robots + 1 && page.robot_utime == 3'000'000 && page.num_rays == 2));
  CHECK(page.feed.Hear("scan 0", true));  // of which there are no rays
  page.TakeAll();
  CHECK((page.robot_utime == 1'000'000 && page.num_rays == 0));
  CHECK_FALSE(page.feed.Next());
  for (const char* text :
       {"scan 5", "scan -1", "scan", "scan ", "scan 1 ", "scan 18446744073709551616", "", "start 1 2 3"}) {
    CAPTURE(text);
    CHECK_FALSE(page.feed.Hear(text, true));
  }
  CHECK_FALSE(page.feed.Hear("scan 1", false));
}

TEST_CASE(
    "a page is told how a finished run was known at a moment, by the tiles that differ, and goes back to the end") {
  Page page;
  History history;
  Scene then("");
  const auto Add = [&](int num_scans, std::size_t num_closed) {
    then.SetPath(PathOf(num_scans), true);
    then.SetLoops({num_closed, PlacedLoop{{2.0, 0.0, 0.0}, {}}});
    history.Add(then, num_closed);
  };
  then.map().Set({0, 0}, Filled(200), 1);
  Add(10, 0);
  then.map().Set({1, 0}, Filled(200), 2);
  Add(20, 1);
  page.scene.map().Set({0, 0}, Filled(100), 3);
  page.scene.map().Set({2, 0}, Filled(100), 3);
  page.scene.map().SetVersion(3, 3);
  history.Finish(page.scene.map(), 30);
  Timeline timeline;
  for (int i = 0; i < 30; ++i) timeline.Add({}, nullptr);
  page.scene.SetTimeline(std::move(timeline));
  page.TakeAll();
  CHECK((page.info["knows_then"] == false && !page.feed.Hear("then 5", true)));
  page.scene.SetHistory(std::make_shared<const History>(std::move(history)));
  page.TakeAll();
  CHECK((page.info["knows_then"] == true && page.num_then == 0));
  const auto last = page.ExploredTiles();

  using Tiles = std::map<TileIndex, TileBytes>;
  const auto Ask = [&](int scan) {
    page.num_whole_tiles = 0;
    CHECK(page.feed.Hear("then " + std::to_string(scan), true));
    page.TakeAll();
  };
  for (const int scan : {0, 9, 18}) {
    Ask(scan);
    CHECK((page.ExploredTiles() == Tiles{{{0, 0}, Filled(200)}} && page.path.size() == PathOf(10).kept().size() &&
           page.then_loop_x_m.empty()));
    CHECK(page.num_whole_tiles == (scan == 0 ? 3 : 0));  // all that there ever were
  }
  Ask(19);
  CHECK(page.ExploredTiles() == Tiles{{{0, 0}, Filled(200)}, {{1, 0}, Filled(200)}});
  CHECK((page.then_num_closed == 1 && page.then_loop_x_m == std::vector{2.0F} && !page.then_is_end));
  Ask(29);
  CHECK((page.ExploredTiles() == last && page.then_is_end && page.path.empty() && page.version == 3));
  for (const char* text : {"then 30", "then -1", "then", "then x"}) CHECK_FALSE(page.feed.Hear(text, true));
}

TEST_CASE(
    "a scan floats if it has a pose, is lost if it has none, and without rays if nothing of it was a measurement") {
  Page page;
  Timeline timeline;
  PathSketch path;
  for (const bool floating : {false, true}) {
    for (const auto& [state, num_critical] : {std::pair(MatchState::kOk, 20), std::pair(MatchState::kDegenerate, 20),
                                              std::pair(MatchState::kLost, 20), std::pair(MatchState::kLost, 0)}) {
      ScanMatch match;
      match.T_map_laser.x_m = static_cast<double>(timeline.size());
      match.state = state;
      match.num_critical = num_critical;
      match.floating = floating;
      timeline.Add(match, nullptr);
      path.Add(match);
    }
  }
  page.scene.SetTimeline(timeline);
  page.scene.SetPath(path, true);
  page.TakeAll();
  CHECK(page.timeline_state == std::vector<std::uint8_t>{1, 3, 2, 5, 4, 4, 2, 5});
  REQUIRE(page.path.size() == 8);
  for (std::size_t i = 0; i < 8; ++i) CHECK(page.path[i].state == page.timeline_state[i]);
  for (const auto& [scan, state] : {std::pair("scan 4", 1), std::pair("scan 5", 3), std::pair("scan 7", 5)}) {
    page.feed.Hear(scan, true);
    page.TakeAll();
    CHECK((page.robot_state == state && page.robot_floats));
  }
}

TEST_CASE("a scan that the run has not kept is shown by the one before it, as it is seen from its place") {
  Timeline timeline;
  ScanMatch match;
  match.T_map_laser = {1.0, 2.0, 0.5};
  const CriticalRays scan{0, {{0.25f, -3.0f}, {2.0f, 30.0f}}, {0}};
  timeline.Add(match, &scan);
  CHECK(timeline.scan(0).critical == std::vector{0});
  CHECK(timeline.scan(0).rays.angle_rad[1] == Approx(-3.0).margin(1e-4));
  CHECK(timeline.scan(0).rays.range_m[1] == Approx(30.0).margin(4e-3));
  match.T_map_laser = {2.0, 2.0, 1.0};
  timeline.Add(match, nullptr);
  const CriticalRays seen = timeline.scan(1);
  const double angle_rad = 1.0 + seen.rays.angle_rad[0];
  CHECK(2.0 + seen.rays.range_m[0] * std::cos(angle_rad) == Approx(1.0 + 2.0 * std::cos(0.75)).margin(0.01));
  CHECK(2.0 + seen.rays.range_m[0] * std::sin(angle_rad) == Approx(2.0 + 2.0 * std::sin(0.75)).margin(0.01));
  match.trajectory = 1;
  timeline.Add(match, nullptr);
  CHECK(timeline.scan(2).rays.size() == 0);  // nobody knows where the one before was, seen from there
}

TEST_CASE("where a robot is may be said where somebody listens, in three numbers") {
  Page page;
  CHECK_FALSE(page.feed.Hear("start 1 2 0.5", true));  // nobody listens
  std::vector<Pose2> told;
  page.scene.SetStartHandler([&](const Pose2& T_map_laser) { told.push_back(T_map_laser); });
  CHECK(page.feed.Hear("start 1 -2.5 0.5", true));
  CHECK(told == std::vector<Pose2>{{1.0, -2.5, 0.5}});
  for (const char* text : {"start", "start ", "start 1 2", "start 1 2 3 4", "start 1 2 ", "start 1  2", "start nan 2 3",
                           "start 1 inf 3", "start 1e7 2 3", "start a b c", "stop 1 2 3"}) {
    CAPTURE(text);
    CHECK_FALSE(page.feed.Hear(text, true));
  }
  CHECK_FALSE(page.feed.Hear("start 1 2 3", false));
  CHECK(told.size() == 1);
}

TEST_CASE("services, news and loops that hold are told as JSON, whatever their names are") {
  Scene scene("robot1/");
  scene.SetInfo(R"({"services":[{"name":"\u0000<b>"}]})");
  scene.SetLoops({{{1.0, 2.0, 0.0}, {3.0, 4.0, 0.0}, false}, {{5.0, 6.0, 0.0}, {7.0, 8.0, 0.0}, true}});
  PageFeed feed(scene, {"robot1/", "bad \xff name"}, {});
  PageClient client;
  const auto TakeAll = [&] {
    while (const auto message = feed.Next()) client.Take(message->bytes);
  };
  TakeAll();
  CHECK(client.info["news"] == nlohmann::json{{"number", 0}, {"text", ""}});
  scene.AddNews({"joined"});
  TakeAll();
  CHECK(client.info["news"] == nlohmann::json{{"number", 1}, {"text", "joined"}});
  CHECK(client.info["robot"] == "robot1/");
  CHECK(client.info["robots"].size() == 2);
  CHECK(client.info["loops"] == nlohmann::json::parse("[[1.0, 2.0, 3.0, 4.0]]"));  // the other was rejected
  CHECK_FALSE(feed.Hear("{}", true));                                              // a page has nothing to say
}

}  // namespace crsm
