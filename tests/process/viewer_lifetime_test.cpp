// The page of run_stack --view, from before the first scan on.

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
