#include "services/map_viewer/foxglove_feed.hpp"

#include <pthread.h>

#include <cstring>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "catch.hpp"

namespace crsm {
namespace {

using nlohmann::json;

TileBytes Filled(std::uint8_t byte) {
  TileBytes cells;
  cells.fill(byte);
  return cells;
}

SceneRobot RobotAt(double x_m) {
  SceneRobot robot;
  robot.match.utime = 1'700'000'000'250'000;
  robot.match.T_map_laser = {x_m, -1.0, 0.0};
  robot.scan = {0, {{-0.5F, 0.0F, 0.25F}, {1.0F, 2.0F, 3.0F}}, {}};
  return robot;
}

/// A scene, and what Foxglove knows of it.
struct Client {
  Client() { TakeAll(); }

  void TakeAll() {
    while (const auto message = feed.Next()) {
      if (message->is_text) {
        TakeText(json::parse(message->bytes));
      } else {
        REQUIRE(message->bytes.size() > 13);
        REQUIRE(message->bytes[0] == 1);
        std::uint32_t subscription = 0;
        std::memcpy(&subscription, message->bytes.data() + 1, sizeof(subscription));
        std::memcpy(&time_ns, message->bytes.data() + 5, sizeof(time_ns));
        told[subscription] = json::parse(message->bytes.substr(13));
        ++num_told;
      }
    }
    CHECK_FALSE(feed.has_more());
  }

  /// When a topic may be told again.
  void TakeLater() {
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    TakeAll();
  }

  void TakeText(const json& message) {
    texts.push_back(message["op"]);
    if (message["op"] != "advertise") return;
    for (const json& channel : message["channels"]) channels[channel["topic"]] = channel["id"];
  }

  bool Subscribe(const std::string& topic, std::uint32_t id) {
    const json message{{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channels.at(topic)}}}}};
    const bool heard = feed.Hear(message.dump(), true);
    TakeAll();
    return heard;
  }

  Scene scene{""};
  Scene other{"robot2/"};
  FoxgloveFeed feed{{FoxgloveScene(scene, ""), FoxgloveScene(other, "robot2/")}};
  std::vector<std::string> texts;
  std::map<std::string, std::uint32_t> channels;
  std::map<std::uint32_t, json> told;  ///< by subscription, the last
  int num_told = 0;
  std::uint64_t time_ns = 0;
};

void RunWithStack(std::size_t num_bytes, std::function<void()> run) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  REQUIRE(pthread_attr_setstacksize(&attributes, num_bytes) == 0);
  pthread_t thread;
  const auto Run = [](void* function) -> void* {
    (*static_cast<std::function<void()>*>(function))();
    return nullptr;
  };
  REQUIRE(pthread_create(&thread, &attributes, Run, &run) == 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
}

}  // namespace

TEST_CASE("Foxglove is greeted, told of the topics, and of a block of the map when there is one") {
  Client client;
  CHECK(client.texts == std::vector<std::string>{"serverInfo", "advertise"});
  CHECK(client.channels.size() == 5 + 5);  // of two robots
  client.scene.map().Set({-1, 0}, Filled(200), 1);
  client.scene.map().Set({7, 7}, Filled(200), 1);
  client.TakeAll();
  CHECK(client.texts.size() == 3);
  CHECK(client.channels.count("/map/-1_0") == 1);
  CHECK(client.channels.count("/map/0_0") == 1);
  CHECK(client.channels.size() == 7 + 5);
  CHECK(client.num_told == 0);  // nothing was asked for

  TileBytes cells = Filled(10);
  cells[1] = 20;
  client.scene.map().Set({-8, 7}, cells, 1);  // in the block of the first
  client.Subscribe("/map/-1_0", 1);
  const json& grid = client.told[1];
  CHECK(grid["pose"]["position"] == json{{"x", -25.6}, {"y", 0.0}, {"z", 0.0}});
  const std::string data = grid["data"];
  REQUIRE(data.size() == (512 * 512 + 2) / 3 * 4);
  CHECK(data.starts_with("f39/"));                            // unexplored: 127 127 127
  CHECK(data.substr((63 * 512 + 450) / 3 * 4, 4) == "yMjI");  // 200 in the last tile of the first row
  CHECK(data.substr((448 * 512 + 1) / 3 * 4, 4) == "FAoK");   // 20 10 10 in the first tile of the last row, ...
  CHECK(data.substr((511 * 512 + 1) / 3 * 4, 4) == "CgoK");   // ... and above it 10 10 10
}

TEST_CASE("a topic that was subscribed to is told when it has changed, and no more after that") {
  Client client;
  CHECK(client.Subscribe("/pose", 5));
  CHECK(client.num_told == 0);  // no robot yet
  client.scene.SetRobot(RobotAt(2.0));
  client.TakeAll();
  CHECK(client.num_told == 1);
  CHECK(client.told[5]["pose"]["position"]["x"] == 2.0);
  CHECK(client.told[5]["timestamp"] == json{{"sec", 1'700'000'000}, {"nsec", 250'000'000}});
  CHECK(client.time_ns == 1'700'000'000'250'000'000U);
  client.TakeAll();
  CHECK(client.num_told == 1);
  client.scene.SetRobot(RobotAt(3.0));
  client.TakeLater();
  CHECK(client.told[5]["pose"]["position"]["x"] == 3.0);
  CHECK(client.feed.Hear(R"({"op":"unsubscribe","subscriptionIds":[5]})", true));
  client.scene.SetRobot(RobotAt(4.0));
  client.TakeLater();
  CHECK(client.num_told == 2);
  for (std::uint32_t id = 0; id < 1000; ++id) CHECK(client.Subscribe("/robot2/tf", id));  // told once, by the last
  client.other.SetRobot(RobotAt(2.0));
  client.TakeAll();
  CHECK(client.num_told == 3);
  CHECK(client.told[999]["parent_frame_id"] == "robot2/map");  // robots have topics and frames of their own
  CHECK(client.told[999]["child_frame_id"] == "robot2/laser");
}

TEST_CASE("a scan with gaps is told at equal steps of the angle, 0 where nothing was measured") {
  Client client;
  client.scene.SetRobot(RobotAt(2.0));
  client.Subscribe("/scan", 0);
  CHECK(client.told[0]["start_angle"] == -0.5);
  CHECK(client.told[0]["end_angle"] == 0.25);
  CHECK(client.told[0]["ranges"] == json({1.0, 0.0, 2.0, 3.0}));
  for (const ValidRays& rays : {ValidRays{}, ValidRays{{0.5F}, {1.0F}}, ValidRays{{0.5F, 0.5F}, {1.0F, 2.0F}},
                                ValidRays{{-3.0F, 1e-30F, 3.0F}, {1.0F, 2.0F, 3.0F}}}) {
    SceneRobot robot;
    robot.scan.rays = rays;
    client.scene.SetRobot(robot);
    client.TakeLater();
    CHECK(client.told[0]["ranges"].size() <= 8193);
    CHECK(client.told[0]["ranges"].size() >= std::min<std::size_t>(1, rays.size()));
  }
}

TEST_CASE("what floats is a path of its own, and what happens is a log, of which there is a topic when there is one") {
  Client client;
  PathSketch path;
  for (const bool floating : {false, true, true}) {
    ScanMatch match;
    match.T_map_laser = {static_cast<double>(path.num_matches()), 0.0, 0.0};
    match.state = MatchState::kOk;
    match.floating = floating;
    path.Add(match);
  }
  client.scene.SetPath(path, true);
  client.Subscribe("/path", 1);
  client.Subscribe("/floating_path", 2);
  CHECK(client.told[1]["poses"].size() == 1);
  REQUIRE(client.told[2]["poses"].size() == 2);
  CHECK(client.told[2]["poses"][1]["position"]["x"] == 2.0);
  client.scene.AddNews({});
  client.TakeAll();
  CHECK(client.channels.count("/log") == 0);
  client.scene.AddNews({"one", "two"});
  client.TakeAll();
  REQUIRE(client.channels.count("/log") == 1);
  client.Subscribe("/log", 3);
  CHECK(client.told[3]["message"] == "one; two");
  CHECK(client.told[3]["level"] == 2);
  CHECK_FALSE(client.told[3].contains("frame_id"));
  std::this_thread::sleep_for(std::chrono::milliseconds(40));
  client.scene.AddNews({"two"});
  client.TakeAll();
  CHECK(client.told[3]["message"] == "two");
}

TEST_CASE("what Foxglove does not say is not believed") {
  Client client;
  for (const char* text :
       {"", "x", "[]", "1", "null", "{", R"({"op":"subscribe","subscriptions":[1]})",
        R"({"op":"subscribe","subscriptions":[{"id":0}]})", R"({"op":"subscribe","subscriptions":[{"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":99}]})",
        R"({"op":"subscribe","subscriptions":[{"id":"0","channelId":0.5}]})"}) {
    INFO(text);
    CHECK_FALSE(client.feed.Hear(text, true));
  }
  CHECK_FALSE(client.feed.Hear("{}", false));
  for (const char* text : {"{}", R"({"op":7})", R"({"op":"subscribe"})", R"({"op":"subscribe","subscriptions":{}})",
                           R"({"op":"unsubscribe","subscriptionIds":[null,"x",9]})", R"({"op":"fetchAsset"})"}) {
    INFO(text);
    CHECK(client.feed.Hear(text, true));
  }
}

TEST_CASE("what a client nests ten thousand times deep is heard with a stack of 128 KB") {
  Client client;
  const std::string deep = std::string(10000, '[') + std::string(10000, ']');
  const std::vector<std::string> texts{deep, R"({"op":)" + deep + "}",
                                       R"({"op":"subscribe","subscriptions":[)" + deep + "]}",
                                       R"({"op":"unsubscribe","subscriptionIds":)" + deep + "}"};
  const auto Hear = [&] {
    for (const std::string& text : texts) client.feed.Hear(text, true);
  };
  RunWithStack(std::size_t{128} * 1024, Hear);
}

TEST_CASE("the layout shows what Foxglove hides") {
  const json layout = json::parse(MakeFoxgloveLayout({"robot1/", "robot2/"}));
  const json& topics = layout["configById"][layout["layout"].get<std::string>()]["topics"];
  for (const char* topic : {"/robot1/map/0_0", "/robot2/map/-8_7", "/robot1/scan", "/robot2/path", "/robot1/pose",
                            "/robot1/floating_path"}) {
    INFO(topic);
    CHECK(topics[topic]["visible"] == true);
  }
  CHECK(topics["/robot1/map/0_0"]["colorField"] == "cell");
  CHECK(json::accept(MakeFoxgloveLayout({"caf\xe9/"})));  // a folder's name need not be UTF-8
}

}  // namespace crsm
