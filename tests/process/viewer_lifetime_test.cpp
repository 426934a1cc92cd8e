// The page of run_stack --view, from before the first scan until after the end of the run.

#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <regex>

#include "catch.hpp"
#include "viewer_page.hpp"

using namespace crsm;

namespace {

constexpr const char* kIsAt = "run_stack: the map is at ";
constexpr const char* kStaysAt = "run_stack: the map stays at ";

struct Link {
  std::string text;
  std::uint16_t port = 0;
  std::string token;

  std::string query() const { return "robot=0&token=" + token; }
};

/// The first link behind some words.
Link FindLink(const std::string& said, const std::string& words) {
  const auto at = said.find(words);
  REQUIRE(at != std::string::npos);
  std::smatch parts;
  const std::string rest = said.substr(at + words.size());
  REQUIRE(std::regex_search(rest, parts, std::regex("^http://[^/ ]*:([0-9]+)/(#token=([0-9a-f]{32}))?")));
  return {parts[0], static_cast<std::uint16_t>(std::stoi(parts[1])), parts[3]};
}

/// run_stack --view, which has said where the map is.
class ViewedStack {
 public:
  ViewedStack(const std::string& source, std::vector<std::string> flags)
      : stack_(folder_.StartStack(source, "out", url_, WithView(std::move(flags)))) {
    REQUIRE(stack_.AwaitSaid(kIsAt));
  }

  Process& process() { return stack_; }
  const TemporaryFolder& folder() const { return folder_; }
  const std::string& url() const { return url_; }
  Link link() const { return FindLink(stack_.errors(), kIsAt); }

  /// Where it stays; the test fails if it does not.
  Link AwaitStays() {
    INFO(stack_.errors());
    REQUIRE(stack_.AwaitSaid(kStaysAt));
    return FindLink(stack_.errors(), kStaysAt);
  }

 private:
  static std::vector<std::string> WithView(std::vector<std::string> flags) {
    flags.push_back("--view");
    if (std::find(flags.begin(), flags.end(), "--http") == flags.end()) {
      flags.insert(flags.end(), {"--http", "127.0.0.1:0"});
    }
    return flags;
  }

  TemporaryFolder folder_;
  std::string url_ = MakeBusUrl();
  Process stack_;
};

bool IsServed(const Link& link) {
  try {
    return AskHttp(link.port, "/").starts_with("HTTP/1.1 200 OK\r\n");
  } catch (const std::runtime_error&) {  // nobody listens
    return false;
  }
}

std::string StatusOfUpgrade(const Link& link, const std::string& token) {
  return WebSocketClient(link.port, "/live?robot=0&token=" + token, PageFeed::kSubprotocol).status();
}

}  // namespace

TEST_CASE("when a run has ended its page stays at the same address, and shows the finished run", "[viewer]") {
  ViewedStack stack("sim:demo", {"--http", "0.0.0.0:0", "--rate", "60"});
  const Link live = stack.link();
  Page page(live.port, live.query());
  REQUIRE(page.Await([&] { return page->complete && page->version > 20; }));
  CHECK(page->info.value("live", true));

  const Link finished = stack.AwaitStays();
  CHECK(finished.text == live.text);
  CHECK_FALSE(page.Await([] { return false; }));  // its connection has ended
  const nlohmann::json summary = stack.folder().Summary("out");
  CHECK(stack.process().output().find("see " + (stack.folder() / "out").string()) != std::string::npos);
  Page late(finished.port, finished.query());
  REQUIRE(late.Await([&] { return late->complete && !late->info.is_null(); }));
  CHECK(late->version == summary["map_version"]);
  CHECK(late->info["live"] == false);
  CHECK(late->info["scans"] == summary["scans"]);
  CHECK(StatusOfUpgrade(finished, std::string(32, '0')) == "HTTP/1.1 401 Unauthorized");

  CHECK(stack.process().Interrupt() == 0);
  CHECK_FALSE(IsServed(finished));
}

TEST_CASE("a page that has some of the live map, and connects again, gets the whole finished map", "[viewer]") {
  ViewedStack stack("sim:block", {});
  const Link link = stack.link();
  std::string cursor;
  {
    Page page(link.port, link.query());
    page.Await([&] {
      if (page->complete && page->version > 0) {
        cursor = "&epoch=" + std::to_string(page->epoch) + "&version=" + std::to_string(page->version);
      }
      return false;
    });
  }
  REQUIRE_FALSE(cursor.empty());
  stack.AwaitStays();
  Page fresh(link.port, link.query());
  Page returned(link.port, link.query() + cursor);
  for (Page* page : {&fresh, &returned}) {
    REQUIRE(page->Await([&] { return (*page)->complete && !(*page)->info.is_null(); }));
  }
  CHECK((returned->ExploredTiles() == fresh->ExploredTiles()));  // without printing them
  CHECK(returned->version == fresh->version);
  CHECK(stack.process().Interrupt() == 0);
}

TEST_CASE("Ctrl-C ends a live run, and once more the page; SIGTERM ends both at once", "[viewer]") {
  for (const int signal : {SIGINT, SIGTERM}) {
    ViewedStack stack("sim:demo", {"--rate", "2"});
    const Link link = stack.link();
    Page page(link.port, link.query());
    REQUIRE(page.Await([&] { return page->complete && page->version > 5; }));
    stack.process().Signal(signal);
    if (signal == SIGINT) {
      stack.AwaitStays();
      Page finished(link.port, link.query());
      REQUIRE(finished.Await([&] { return finished->complete && !finished->info.is_null(); }));
      stack.process().Signal(SIGINT);
    }
    CHECK(stack.process().AwaitExit() == 0);
    CHECK(stack.folder().Summary("out")["scans"] > 0);
    CHECK((stack.process().errors().find(kStaysAt) != std::string::npos) == (signal == SIGINT));
  }
}

TEST_CASE("SIGTERM ends a page that stays, and the exit code is that of the run", "[viewer]") {
  ViewedStack stack("sim:demo", {"--strict", "--range-max-m", "0.6"});  // a laser that sees hardly a wall
  stack.AwaitStays();
  INFO(stack.process().output());
  stack.process().Signal(SIGTERM);
  CHECK(stack.process().AwaitExit() == 3);
}

TEST_CASE("a run that has mapped nothing leaves no page", "[viewer]") {
  ViewedStack stack("live", {});
  Page page(stack.link().port);  // which is there before any scan
  REQUIRE(page.Await([&] { return page->info.contains("services"); }));
  REQUIRE(stack.process().AwaitSaid("run_stack: listening; Ctrl-C ends"));
  CHECK(stack.process().Interrupt() == 0);
  CHECK(stack.process().errors().find(kStaysAt) == std::string::npos);
  CHECK(stack.process().errors().find("map_viewer failed") == std::string::npos);
}

TEST_CASE("the page is there before the laser is, and ends with run_stack", "[viewer]") {
  ViewedStack stack("hokuyo:tcp://127.0.0.1:1", {});
  const Link link = stack.link();
  CHECK(IsServed(link));
  REQUIRE(stack.process().AwaitSaid("trying again until it answers"));
  Page page(link.port);
  REQUIRE(page.Await([&] { return !page->info.is_null(); }));
  CHECK(stack.process().Interrupt() == 1);
  CHECK(WaitUntil([&] { return !IsServed(link); }));
}

TEST_CASE("a viewer that is killed comes back at the same address, with the same token and no flag that has it",
          "[viewer]") {
  ViewedStack stack("live", {"--http", "0.0.0.0:0"});
  const Link link = stack.link();
  REQUIRE(stack.process().AwaitSaid("run_stack: listening; Ctrl-C ends"));
  const pid_t viewer = FindChild(stack.process().pid(), "map_viewer");
  REQUIRE(viewer > 0);
  CHECK(ReadFile("/proc/" + std::to_string(viewer) + "/cmdline").find(link.token) == std::string::npos);
  kill(viewer, SIGKILL);
  REQUIRE(stack.process().AwaitSaid("run_stack: map_viewer ended unexpectedly (signal 9): restarted"));
  REQUIRE(WaitUntil([&] { return IsServed(link); }));
  CHECK(StatusOfUpgrade(link, link.token) == "HTTP/1.1 101 Switching Protocols");
  CHECK(StatusOfUpgrade(link, std::string(32, '0')) == "HTTP/1.1 401 Unauthorized");
  CHECK(stack.process().Interrupt() == 0);
  CHECK(CountOf(link.text, stack.process().errors()) == 1);  // it was said already
}
