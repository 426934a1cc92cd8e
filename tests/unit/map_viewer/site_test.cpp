#include "services/map_viewer/site.hpp"

#include "catch.hpp"
#include "services/map_viewer/page_feed.hpp"

namespace crsm {
namespace {

WebRequest Get(const std::string& target) { return {"GET", target, "localhost:8765", {}, false, {}}; }

WebRequest Live(const std::string& target) {
  return {"GET", target, "localhost:8765", "http://localhost:8765", true, {PageFeed::kSubprotocol}};
}

// Who is let in to what is tested with a viewer that runs.
class TestSite {
 public:
  /// 101 where a feed is the answer.
  unsigned StatusOf(const WebRequest& request) const {
    const WebAnswer answer = site_.Answer(request);
    const auto* page = std::get_if<WebPage>(&answer);
    return page ? page->status : 101;
  }
  WebPage PageOf(const std::string& target) const { return std::get<WebPage>(site_.Answer(Get(target))); }

 private:
  Scene one_{"robot1/"};
  Scene two_{"robot2/"};
  Scene piece_{"robot2/pieces/3"};
  Site site_{{&one_, &two_}, Access(true, ""), {}, {{1, 1, &two_}, {1, 3, &piece_}}};
};

}  // namespace

TEST_CASE("the page and all that it names are there, and nothing else") {
  const TestSite site;
  const WebPage index = site.PageOf("/");
  CHECK(index.status == 200);
  CHECK(index.content_type == "text/html; charset=utf-8");
  CHECK(index.body.starts_with("<!doctype html>"));
  CHECK(site.PageOf("/main.js?x=1").content_type == "text/javascript; charset=utf-8");
  CHECK(site.PageOf("/style.css").content_type == "text/css; charset=utf-8");
  CHECK(site.PageOf("/foxglove-layout.json").body.find("/robot2/map/0_0") != std::string::npos);
  CHECK(site.PageOf("/icon.svg").content_type == "image/svg+xml");
  for (const char* target : {"", "*", "/..", "/../main.cpp", "/main", "//main.js", "/MAIN.JS", "main.js", "/live",
                             "http://localhost/", "/main.js/"}) {
    INFO(target);
    CHECK(site.StatusOf(Get(target)) == 404);
  }
  // Whatever a page fetches comes from here.
  for (const char* file : {"/", "/style.css", "/main.js", "/map_view.js", "/wire.js", "/panel.js", "/charts.js",
                           "/layers.js", "/map_model.js", "/robot_model.js"}) {
    INFO(file);
    const WebPage page = site.PageOf(file);
    CHECK(page.status == 200);
    CHECK(page.body.find("https://") == std::string::npos);
    CHECK(page.body.find("http://") == std::string::npos);
    CHECK(page.body.find("eval(") == std::string::npos);
    CHECK(page.body.find(" style=") == std::string::npos);
  }
}

TEST_CASE("a feed is of a robot that is there, in a language that is spoken here") {
  const TestSite site;
  CHECK(site.StatusOf(Live("/live?robot=0")) == 101);
  CHECK(site.StatusOf(Live("/live?robot=1&epoch=99999999999999999999&version=x")) == 101);
  CHECK(site.StatusOf(Live("/live?robot=2")) == 404);
  CHECK(site.StatusOf(Live("/live?robot=-1")) == 404);
  CHECK(site.StatusOf(Live("/live?robot=1&piece=3")) == 101);
  for (const char* other : {"robot=0&piece=1", "robot=1&piece=2", "robot=1&piece=-3", "robot=3", "robot=4"}) {
    INFO(other);
    CHECK(site.StatusOf(Live(std::string("/live?") + other)) == 404);
  }
  WebRequest other = Live("/live?robot=0");
  other.subprotocols = {"crsm.view.v2", "mqtt"};
  CHECK(site.StatusOf(other) == 400);
  other.subprotocols = {};
  CHECK(site.StatusOf(other) == 400);
  other.target = "/";
  for (const char* subprotocol : {"foxglove.sdk.v1", "foxglove.websocket.v1"}) {
    other.subprotocols = {"x", subprotocol};
    for (const char* origin : {"https://app.foxglove.dev", "file://", "http://localhost:8765"}) {
      other.origin = origin;
      CHECK(site.StatusOf(other) == 101);
    }
    other.origin = "http://evil.example";
    CHECK(site.StatusOf(other) == 403);
  }
}

}  // namespace crsm
