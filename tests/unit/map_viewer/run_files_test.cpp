#include "services/map_viewer/run_files.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "catch.hpp"
#include "services/map_viewer/site.hpp"
#include "unit/scratch.hpp"

namespace crsm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kToken = "0123456789abcdef0123456789abcdef";

/// Two folders of runs, and a viewer that shows them to who has the token.
class TwoRuns {
 public:
  TwoRuns() {
    for (const fs::path& folder : {one(), two() / "pieces/2"}) fs::create_directories(folder);
    std::ofstream(one() / "map.png") << "a picture";
    std::ofstream(two() / "pieces/2/map.png") << "a piece";
    std::ofstream(one() / "trajectory.tum") << "0 0 0 0 0 0 0 1\n";
    std::ofstream(one() / "secret.txt") << "of somebody else";
    fs::create_symlink(one() / "secret.txt", one() / "graph.g2o");
    fs::create_directory(one() / "summary.json");
    REQUIRE(mkfifo((one() / "map.yaml").c_str(), 0600) == 0);
  }

  fs::path one() const { return scratch_.path() / "one"; }
  fs::path two() const { return scratch_.path() / "two"; }

  WebAnswer Ask(const std::string& target, const std::string& fetch_site = "") {
    WebRequest request{"GET", target, "localhost:8765", {}, false, {}, fetch_site};
    return site_.Answer(request);
  }
  /// With the token.
  WebAnswer Get(const std::string& path, const std::string& robot = "0") {
    return Ask(path + "?robot=" + robot + "&token=" + kToken);
  }

 private:
  ScratchFolder scratch_;
  Scene first_{"one"};
  Scene second_{"two"};
  Scene piece_{two() / "pieces/2"};
  Site site_{{&first_, &second_}, Access(false, kToken), {one(), two()}, {{1, 2, &piece_}}};
};

WebPage PageOf(const WebAnswer& answer) {
  const auto* page = std::get_if<WebPage>(&answer);
  return page ? *page : WebPage{0, "", "no page"};
}

std::string TextOf(const WebAnswer& answer) {
  const auto* file = std::get_if<WebFile>(&answer);
  if (!file) return "no file";
  std::string text(file->bytes->size(), ' ');
  file->bytes->Read(0, {reinterpret_cast<std::uint8_t*>(text.data()), text.size()});
  return text;
}

/// What comes of an answer that takes its time.
WebReply Await(const WebAnswer& answer) {
  const auto& later = std::get<WebLater>(answer);
  for (;;) {
    if (auto reply = later.poll()) return *reply;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

TEST_CASE("a finished run's files are listed and sent, each of its own robot") {
  TwoRuns runs;
  CHECK(nlohmann::json::parse(PageOf(runs.Get("/files")).body) ==
        nlohmann::json::parse(R"([{"name": "map.png", "bytes": 9}, {"name": "trajectory.tum", "bytes": 16},
                                  {"name": "run.mcap", "bytes": null}])"));
  CHECK(PageOf(runs.Get("/files")).content_type == "application/json");
  CHECK(nlohmann::json::parse(PageOf(runs.Get("/files", "1")).body).size() == 1);
  const WebAnswer picture = runs.Get("/files/map.png");
  CHECK(TextOf(picture) == "a picture");
  CHECK(std::get<WebFile>(picture).name == "map.png");
  CHECK(std::get<WebFile>(picture).content_type == "image/png");
  CHECK(TextOf(runs.Get("/files/trajectory.tum")) == "0 0 0 0 0 0 0 1\n");
  CHECK(PageOf(runs.Get("/files/map.png", "1")).status == 404);
  CHECK(TextOf(runs.Get("/files/map.png", "1&piece=2")) == "a piece");
  CHECK(PageOf(runs.Get("/files/map.png", "2")).body == "robot, piece: nothing has this number\n");
  CHECK(PageOf(runs.Get("/files", "2")).status == 404);
}

TEST_CASE("only plain files of the known names are sent: no link, no FIFO, no folder, no path") {
  TwoRuns runs;
  for (const char* name : {"graph.g2o", "map.yaml", "summary.json", "map.pgm"}) {
    INFO(name);
    const WebPage page = PageOf(runs.Get(std::string("/files/") + name));
    CHECK(page.status == 404);
    CHECK(page.body == std::string(name) + ": this run has no such file\n");
  }
  for (const char* path :
       {"/files/", "/files/secret.txt", "/files/../one/map.png", "/files/two/../map.png", "/files//map.png",
        "/files/MAP.PNG", "/files/map.png/", "/files/journal/journal.lcm", "/files/%6dap.png", "/files/map.png%00"}) {
    INFO(path);
    const WebPage page = PageOf(runs.Get(path));
    CHECK(page.status == 404);
    CHECK(page.body == "no file of a run has this name\n");
  }
  CHECK(PageOf(runs.Get("/filesystem")).body == "not found\n");
}

TEST_CASE("files are for those who have the token, and for no page of another site") {
  TwoRuns runs;
  for (const char* target : {"/files", "/files/map.png", "/files/run.mcap",
                             "/files/map.png?token=", "/files/map.png?token=0123456789abcdef0123456789abcdee"}) {
    INFO(target);
    CHECK(PageOf(runs.Ask(target)).status == 401);
  }
  const std::string target = std::string("/files/map.png?token=") + kToken;
  CHECK(TextOf(runs.Ask(target, "same-origin")) == "a picture");
  CHECK(TextOf(runs.Ask(target, "none")) == "a picture");  // typed by the user
  for (const char* site : {"cross-site", "same-site", "?"}) CHECK(PageOf(runs.Ask(target, site)).status == 403);
}

TEST_CASE("a live robot has no files yet") {
  const Scene scene("");
  const Site site({&scene}, Access(true, ""));
  const WebRequest list{"GET", "/files", "localhost", {}, false, {}};
  CHECK(PageOf(site.Answer(list)).body == "[]\n");
  for (const char* target : {"/files/map.png", "/files/run.mcap"}) {
    const WebPage page = PageOf(site.Answer({"GET", target, "localhost", {}, false, {}}));
    CHECK(page.status == 404);
    CHECK(page.body.ends_with(": there when the run has ended\n"));
  }
}

TEST_CASE("a file that is too large is refused, with its size") {
  TwoRuns runs;
  RunFiles files({runs.one()}, 8);
  const WebPage page = PageOf(files.Find(0, "map.png"));
  CHECK(page.status == 500);
  CHECK(page.body == "map.png: has 9 bytes, and no more than 8 are sent; copy it from the folder of the run\n");
  CHECK(TextOf(RunFiles({runs.one()}, 9).Find(0, "map.png")) == "a picture");
}

TEST_CASE("a run.mcap that cannot be made is an error in one line") {
  TwoRuns runs;
  const WebReply reply = Await(runs.Get("/files/run.mcap"));
  const auto* page = std::get_if<WebPage>(&reply);
  REQUIRE(page);
  CHECK(page->status == 500);
  CHECK(page->body == "run.mcap: there is no file " + (runs.one() / "journal/journal.lcm").string() + "\n");
}

}  // namespace crsm
