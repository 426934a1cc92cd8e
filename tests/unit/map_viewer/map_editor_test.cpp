#include "services/map_viewer/map_editor.hpp"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "catch.hpp"
#include "common/results/results.hpp"
#include "services/map_viewer/page_feed.hpp"
#include "services/map_viewer/site.hpp"
#include "unit/scratch.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kToken = "0123456789abcdeffedcba9876543210";
constexpr const char* kCrop = R"({"crop_m": [[0, 0], [1, 1]]})";

std::string ReadAll(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The folder of a run with a map of 2 m x 2 m, and a viewer of it.
class EditedRun {
 public:
  EditedRun() { WriteMap(); }

  void WriteMap() const {
    Results results;
    results.grid = {40, 40, 0, 0, 0.05, std::vector<std::uint8_t>(1600, kFreeByte)};
    WriteResults(dir(), results);
  }

  fs::path dir() const { return scratch_.path(); }
  const Scene& scene() const { return scene_; }
  void Open() { editor_.emplace(dir().string(), scene_); }

  nlohmann::json Told() const { return nlohmann::json::parse(scene_.edits()); }
  /// What is told once nothing is written any more.
  std::string Await() {
    do {
      editor_->Step();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } while (scene_.writes_edits());
    return Told()["state"];
  }

  WebAnswer Get(const std::string& target, const std::string& token = kToken) const {
    return site_.Answer({"GET", target + "?token=" + token, "localhost:8765", {}, false, {}});
  }
  std::unique_ptr<Feed> Connect(const std::string& token) const {
    WebAnswer answer =
        site_.Answer({"GET", "/live?token=" + token, "localhost:8765", {}, true, {PageFeed::kSubprotocol}});
    auto* feed = std::get_if<WebFeed>(&answer);
    return feed ? std::move(feed->feed) : nullptr;
  }

 private:
  ScratchFolder scratch_;
  Scene scene_{"run"};
  Site site_{{&scene_}, Access(false, kToken), {dir().string()}};
  std::optional<MapEditor> editor_;
};

}  // namespace

TEST_CASE("edits are kept beside the map with what is made of them, and removed with it when there are none") {
  EditedRun run;
  const std::string map = ReadAll(run.dir() / "map.png");
  run.Open();
  CHECK(run.Await() == "written");
  CHECK_FALSE(fs::exists(run.dir() / "edits.json"));  // who looks writes nothing
  REQUIRE(run.scene().TakeEdits(kCrop));
  CHECK(run.Told()["state"] == "writing");
  CHECK(run.Await() == "written");
  CHECK(run.Told()["edits"]["crop_m"].size() == 2);
  CHECK(ReadMapEdits(run.dir() / "edits.json").crop.size() == 2);
  CHECK(ReadAll(run.dir() / "map_edited.yaml").find("image: map_edited.png") != std::string::npos);
  CHECK(ReadAll(run.dir() / "map.png") == map);
  REQUIRE(run.scene().TakeEdits("{}"));
  CHECK(run.Await() == "written");
  for (const char* name : {"edits.json", "map_edited.png", "map_edited.yaml"})
    CHECK_FALSE(fs::exists(run.dir() / name));
}

TEST_CASE("of edits that come fast the newest are written, and what are none changes nothing") {
  EditedRun run;
  run.Open();
  for (int i = 1; i <= 50; ++i) REQUIRE(run.scene().TakeEdits("{\"turn_deg\": " + std::to_string(i) + "}"));
  for (const char* text : {"", "{}x", "[]", "{\"turn_deg\": \"NaN\"}", "{\"crop_m\": [[0,0]]}", "{\"x\": 1}"}) {
    CHECK_FALSE(run.scene().TakeEdits(text));
  }
  CHECK(run.Await() == "written");
  CHECK(ReadMapEdits(run.dir() / "edits.json").turn_deg == 50.0);
  REQUIRE(run.scene().TakeEdits(R"({"crop_m": [[50, 50], [51, 51]]})"));
  CHECK(run.Await() == "failed");
  CHECK(run.Told()["why"] == "crop_m, erase: nothing is left of the map");
  CHECK(ReadMapEdits(run.dir() / "edits.json").turn_deg == 50.0);
}

TEST_CASE("a viewer that is started anew knows the edits, and makes the map of them that a run has removed") {
  EditedRun run;
  std::ofstream(run.dir() / "edits.json") << kCrop;
  run.Open();
  CHECK(run.Told()["state"] == "writing");
  CHECK(run.Await() == "written");
  CHECK(fs::exists(run.dir() / "map_edited.png"));
  run.WriteMap();
  CHECK_FALSE(fs::exists(run.dir() / "map_edited.png"));  // which was of another map
  CHECK(fs::exists(run.dir() / "edits.json"));
}

TEST_CASE("edits that somebody has spoilt are told in one line, and can be made anew") {
  EditedRun run;
  std::ofstream(run.dir() / "edits.json") << R"({"crop_m": [[0, 0], [1e9, 1]]})";
  run.Open();
  CHECK(run.Told()["state"] == "failed");
  CHECK(run.Told()["why"] ==
        (run.dir() / "edits.json").string() + ": crop_m[1]: must be a number from -1e+06 to 1e+06");
  REQUIRE(run.scene().TakeEdits(kCrop));
  CHECK(run.Await() == "written");
}

TEST_CASE("the edited map comes as a tar, but not while it is written") {
  EditedRun run;
  run.Open();
  const auto StatusOf = [&](const std::string& target) {
    const WebAnswer answer = run.Get(target);
    const auto* page = std::get_if<WebPage>(&answer);
    return page ? page->status : 200;
  };
  CHECK(StatusOf("/files/map_edited.tar") == 404);
  REQUIRE(run.scene().TakeEdits(kCrop));
  CHECK(StatusOf("/files/map_edited.tar") == 503);
  REQUIRE(run.Await() == "written");
  const WebAnswer answer = run.Get("/files/map_edited.tar");
  const auto& file = std::get<WebFile>(answer);
  std::string tar(file.bytes->size(), ' ');
  file.bytes->Read(0, {reinterpret_cast<std::uint8_t*>(tar.data()), tar.size()});
  CHECK(tar.size() % 512 == 0);
  CHECK(tar.starts_with(std::string("map_edited.png\0", 15)));
  CHECK(tar.substr(257, 8) == std::string("ustar\00000", 8));
  CHECK(tar.substr(512).starts_with(ReadAll(run.dir() / "map_edited.png")));
  const std::string list = std::get<WebPage>(run.Get("/files")).body;
  CHECK(list.find("{\"bytes\":null,\"name\":\"map_edited.tar\"}") != std::string::npos);
  CHECK(std::get<WebPage>(RunFiles({run.dir().string()}, 600).Find(0, "map_edited.tar")).status == 500);
}

TEST_CASE("who has half of the token looks, and who says anything but which scan he wants is sent away") {
  EditedRun run;
  run.Open();
  const std::string half = std::string(kToken).substr(0, 16);
  const auto looks = run.Connect(half);
  REQUIRE(looks);
  for (const char* text : {"edits {}", "start 1 2 3", "mark {}", "edits"}) CHECK_FALSE(looks->Hear(text, true));
  CHECK(run.Told()["state"] == "written");  // nobody has changed anything
  CHECK(looks->Next()->bytes.find("\"looks\":true") != std::string::npos);
  const auto changes = run.Connect(kToken);
  REQUIRE(changes);
  CHECK(changes->Next()->bytes.find("\"looks\":false") != std::string::npos);
  CHECK(changes->Hear(std::string("edits ") + kCrop, true));
  CHECK(run.Await() == "written");
  CHECK(std::get_if<WebFile>(&static_cast<const WebAnswer&>(run.Get("/files/map_edited.tar", half))));
  CHECK_FALSE(run.Connect(half.substr(1)));
  CHECK_FALSE(run.Connect(std::string(kToken).substr(16)));  // the other half
  CHECK_FALSE(run.Connect(""));
}

}  // namespace crsm
