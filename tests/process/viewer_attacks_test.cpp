// map_viewer and those who wish it no good: other sites in the same browser, floods, clients that are slow or silent.

#include <fmt/core.h>

#include <deque>
#include <thread>

#include "catch.hpp"
#include "map_viewer/page_client.hpp"
#include "services/map_viewer/page_feed.hpp"
#include "services/map_viewer/web_server.hpp"
#include "services/wire/conversions.hpp"
#include "web_client.hpp"

using namespace crsm;

namespace {

using Clock = std::chrono::steady_clock;

const std::string kPage = "/live?robot=0";

/// A viewer alone on a bus.
class AloneViewer {
 public:
  explicit AloneViewer(std::vector<std::string> arguments = {}) {
    arguments.insert(arguments.end(), {"--lcm-url", url_});
    viewer_.emplace(std::move(arguments), folder_);
    REQUIRE(viewer_->AwaitReady());
  }

  std::uint16_t port() const { return viewer_->port(); }
  const std::string& url() const { return url_; }
  Process& process() { return viewer_->process(); }

  /// Whether it serves its page before those that it waits for have to go, and is not harmed.
  bool IsWell() {
    const auto begin = Clock::now();
    const bool served = AskHttp(port(), "/").starts_with("HTTP/1.1 200 OK\r\n");
    return served && Clock::now() - begin < WebServer::kRequestPatience && process().IsRunning();
  }

 private:
  TemporaryFolder folder_;
  std::string url_ = MakeBusUrl();
  std::optional<Viewer> viewer_;
};

std::string StatusOf(const std::string& answer) { return answer.substr(0, answer.find("\r\n")); }

}  // namespace

TEST_CASE("a viewer answers only who calls it by its name, and only pages of its own", "[viewer]") {
  AloneViewer viewer;
  const auto Ask = [&](const std::string& host, const std::string& origin) {
    std::map<std::string, std::string> headers{{"Host", host}};
    if (!origin.empty()) headers["Origin"] = origin;
    return StatusOf(AskHttp(viewer.port(), "/main.js", headers));
  };
  CHECK(Ask(fmt::format("127.0.0.1:{}", viewer.port()), "") == "HTTP/1.1 200 OK");
  CHECK(Ask("localhost:1", "http://localhost:1") == "HTTP/1.1 200 OK");  // as behind a tunnel of ssh
  CHECK(Ask("evil.example", "") == "HTTP/1.1 403 Forbidden");
  CHECK(Ask("localhost", "http://evil.example") == "HTTP/1.1 403 Forbidden");
  CHECK(Ask("localhost\r\nHost: localhost", "") == "HTTP/1.1 403 Forbidden");  // which of them?
  CHECK(StatusOf(AskHttp(viewer.port(), "/", {})) == "HTTP/1.1 403 Forbidden");

  const auto Upgrade = [&](const std::string& more) {
    return WebSocketClient(viewer.port(), kPage, PageFeed::kSubprotocol, more).status();
  };
  CHECK(Upgrade("") == "HTTP/1.1 101 Switching Protocols");
  const std::string own = fmt::format("Origin: http://localhost:{}\r\n", viewer.port());
  CHECK(Upgrade(own) == "HTTP/1.1 101 Switching Protocols");
  CHECK(Upgrade("Origin: http://evil.example\r\n") == "HTTP/1.1 403 Forbidden");
  CHECK(Upgrade(own + "Origin: http://evil.example\r\n") == "HTTP/1.1 403 Forbidden");
}

TEST_CASE("every answer tells the browser to fetch nothing from elsewhere, and not to show the page in another",
          "[viewer]") {
  AloneViewer viewer;
  for (const char* target : {"/", "/main.js", "/nowhere"}) {
    const std::string answer = AskHttp(viewer.port(), target);
    CHECK(answer.find("Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "
                      "img-src 'self' blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
                      "frame-ancestors 'none'\r\n") != std::string::npos);
    CHECK(answer.find("X-Content-Type-Options: nosniff\r\n") != std::string::npos);
    CHECK(answer.find("Access-Control-Allow") == std::string::npos);
  }
}

TEST_CASE("a viewer that is reached from elsewhere wants its token", "[viewer]") {
  AloneViewer viewer({"--http", "0.0.0.0:0", "--qr-code"});
  const std::string said = viewer.process().errors();
  const auto at = said.find("/#token=");
  REQUIRE(at != std::string::npos);
  CHECK(said.find("http://0.0.0.0") == std::string::npos);                                // which leads nowhere
  CHECK(said.find(std::string("\n") + "\u2588\u2588\u2588\u2588") != std::string::npos);  // the margin of a QR code
  const std::string token = said.substr(at + 8, 32);
  const auto Upgrade = [&](const std::string& query) {
    return WebSocketClient(viewer.port(), kPage + query, PageFeed::kSubprotocol).status();
  };
  CHECK(Upgrade("") == "HTTP/1.1 401 Unauthorized");
  CHECK(Upgrade("&token=" + token.substr(1)) == "HTTP/1.1 401 Unauthorized");
  CHECK(Upgrade("&token=" + token) == "HTTP/1.1 101 Switching Protocols");
}

TEST_CASE("nothing can be sent to a viewer: neither bodies nor long headers nor what is no HTTP", "[viewer]") {
  AloneViewer viewer;
  const auto Send = [&](const std::string& bytes) {
    TcpClient client(viewer.port());
    client.Send(bytes);
    return StatusOf(client.ReceiveAll());
  };
  CHECK(Send("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n") == "HTTP/1.1 405 Method Not Allowed");
  CHECK(Send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello") ==
        "HTTP/1.1 413 Payload Too Large");
  CHECK(Send("POST / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nhello\r\n") ==
        "HTTP/1.1 413 Payload Too Large");
  CHECK(Send("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(9000, 'x') + "\r\n\r\n") ==
        "HTTP/1.1 431 Request Header Fields Too Large");
  CHECK(Send("GET /" + std::string(9000, 'x') + " HTTP/1.1\r\nHost: localhost\r\n\r\n") ==
        "HTTP/1.1 431 Request Header Fields Too Large");
  for (const std::string& bytes :
       {std::string("\r\n\r\n\r\n"), std::string("GET / HTTP/9.9\r\n\r\n"), std::string("\x16\x03\x01\x02"),
        std::string(100, '\0'), std::string("GET / HTTP/1.1\r\nHost: a\r\nContent-Length: -1\r\n\r\n")}) {
    TcpClient client(viewer.port());
    client.Send(bytes);
    CHECK(client.IsClosed(WebServer::kRequestPatience + std::chrono::seconds(5)));
  }
  CHECK(viewer.IsWell());
}

TEST_CASE("who connects and says nothing, or a byte now and then, keeps nobody out and is sent away", "[viewer]") {
  AloneViewer viewer;
  WebSocketClient page(viewer.port(), kPage, PageFeed::kSubprotocol);
  REQUIRE(page.Receive());
  std::deque<TcpClient> loris;
  for (std::size_t i = 0; i < 2 * WebServer::kMostConnections; ++i) {
    loris.emplace_back(viewer.port()).Send("GET / HTTP/1.1\r\n");
  }
  const auto begin = Clock::now();
  bool all_closed = false;
  while (!all_closed && Clock::now() - begin < 3 * WebServer::kRequestPatience) {
    CHECK(viewer.IsWell());
    all_closed = true;
    for (TcpClient& client : loris) {
      if (client.Send("X-A: b\r\n") && !client.IsClosed(std::chrono::milliseconds(1))) all_closed = false;
    }
  }
  CHECK(all_closed);
  CHECK(page.Receive());  // which was there before them, and stays
}

TEST_CASE("ten thousand connections are survived, and the page is served after them", "[viewer]") {
  AloneViewer viewer;
  WebSocketClient page(viewer.port(), kPage, PageFeed::kSubprotocol);
  REQUIRE(page.Receive());
  const double before_mb = viewer.process().ResidentMb();
  std::deque<TcpClient> open;
  for (int i = 0; i < 10000; ++i) {
    open.emplace_back(viewer.port());
    if (open.size() > 400) open.pop_front();
  }
  CHECK(WaitUntil([&] { return viewer.IsWell(); }));
  CHECK(page.Receive());
  CHECK(viewer.process().ResidentMb() < before_mb + 20);
}

TEST_CASE("pages that are open keep others out only when there are too many of them", "[viewer]") {
  AloneViewer viewer;
  std::deque<WebSocketClient> pages;
  for (std::size_t i = 0; i < WebServer::kMostConnections; ++i) {
    pages.emplace_back(viewer.port(), kPage, PageFeed::kSubprotocol);
    REQUIRE(pages.back().Receive());
  }
  CHECK(TcpClient(viewer.port()).IsClosed(std::chrono::seconds(1)));
  for (WebSocketClient& page : pages) CHECK(page.Receive());
  pages.clear();
  CHECK(WaitUntil([&] { return !TcpClient(viewer.port()).IsClosed(std::chrono::milliseconds(100)); }));
  CHECK(viewer.IsWell());
}

TEST_CASE("a client that breaks the rules of WebSocket, or talks to who does not listen, is sent away", "[viewer]") {
  AloneViewer viewer;
  const auto IsSentAway = [&](const std::function<void(WebSocketClient&)>& misbehave) {
    WebSocketClient client(viewer.port(), kPage, PageFeed::kSubprotocol);
    misbehave(client);
    return client.tcp().IsClosed(std::chrono::seconds(3));
  };
  CHECK(IsSentAway([](WebSocketClient& client) { client.SendText("{}"); }));
  CHECK(IsSentAway([](WebSocketClient& client) { client.SendFrame(0x82, std::string(1 << 20, 'x')); }));
  CHECK(IsSentAway([](WebSocketClient& client) { client.tcp().Send("\x81\x02hi"); }));  // not masked
  CHECK(IsSentAway([](WebSocketClient& client) { client.SendFrame(0x83, "reserved"); }));
  CHECK(IsSentAway([](WebSocketClient& client) { client.SendFrame(0xc1, "compressed"); }));
  CHECK(IsSentAway([](WebSocketClient& client) { client.SendFrame(0x80, "the rest of nothing"); }));
  CHECK(IsSentAway([](WebSocketClient& client) {
    client.tcp().Send(
        std::string("\x82\xff\xff\xff\xff\xff\xff\xff\xff\xff"
                    "mask",
                    14));  // 2^64 - 1 bytes will follow
  }));
  CHECK(IsSentAway([](WebSocketClient& client) {
    for (int i = 0; i < 2 * WebServer::kMostMessagesPerSecond; ++i) client.SendFrame(0x89, "ping");
  }));
  CHECK(viewer.IsWell());
}

TEST_CASE("who floods with fragments that hold nothing is read no faster than others may send", "[viewer]") {
  AloneViewer viewer;
  WebSocketClient client(viewer.port(), kPage, PageFeed::kSubprotocol);
  client.SendFrame(0x02, "");  // of a message that never ends
  std::string fragments;
  while (fragments.size() < 60000) fragments += std::string("\x00\x80mask", 6);
  constexpr std::size_t kMost = 100'000'000;  // many times what the kernel holds for a connection
  CHECK(client.tcp().Flood(fragments, kMost) < kMost);
  CHECK(viewer.IsWell());
}

TEST_CASE("a client that does not read costs no memory, and is told the newest when it reads again", "[viewer]") {
  AloneViewer viewer;
  WebSocketClient slow(viewer.port(), kPage, PageFeed::kSubprotocol);
  WebSocketClient quick(viewer.port(), kPage, PageFeed::kSubprotocol);
  PageClient of_quick;
  TestBus bus(viewer.url());
  critical_rays_t scan{};
  scan.num_rays = 4000;
  scan.num_critical = 0;
  for (int i = 0; i < scan.num_rays; ++i) {
    scan.angle_rad.push_back(static_cast<float>(i) * 1e-3F);
    scan.range_m.push_back(1.0F);
  }
  const auto PublishScans = [&](std::int64_t first, std::int64_t last) {
    for (scan.utime = first; scan.utime <= last; ++scan.utime) {
      ScanMatch match;
      match.utime = scan.utime;
      match.state = MatchState::kOk;
      bus->Publish(kCriticalRaysChannel, scan);
      bus->Publish(kScanMatchChannel, ToMessage(match));
      if (scan.utime % 50 == 0) slow.SendFrame(0x8a, "");  // a pong: who is silent for long is gone
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  };
  std::thread reader([&] {
    while (of_quick.robot_utime < 700) {
      const auto message = quick.Receive();
      if (!message) return;
      of_quick.Take(message->bytes);
    }
  });
  PublishScans(1, 100);
  const double before_mb = viewer.process().ResidentMb();
  PublishScans(101, 700);  // 20 MB of scans
  CHECK(viewer.process().ResidentMb() < before_mb + 5);
  reader.join();
  CHECK(of_quick.robot_utime == 700);
  PageClient of_slow;
  while (of_slow.robot_utime < 700) {
    const auto message = slow.Receive();
    if (!message) break;
    of_slow.Take(message->bytes);
  }
  CHECK(of_slow.robot_utime == 700);
  CHECK(of_slow.num_robots < of_quick.num_robots / 2);
}

TEST_CASE("a client that answers no ping is gone", "[viewer]") {
  AloneViewer viewer;
  WebSocketClient dead(viewer.port(), kPage, PageFeed::kSubprotocol);  // which is not read, nor written to
  CHECK(dead.tcp().IsClosed(WebServer::kSilencePatience + std::chrono::seconds(10)));
  CHECK(viewer.IsWell());
}
